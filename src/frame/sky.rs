//! Stage `sky`: the air between the eye and everything, and what is behind it. Shader: `sky.frag`.

use super::passed::{Ground, Shared};
use super::targets::SCENE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Sky {
    pipeline: GraphicsPipeline,
}

impl Sky {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Sky> {
        let formats = [SCENE_FORMAT];
        let description = GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(shaders::SKY_FRAG), &formats);
        Ok(Sky { pipeline: GraphicsPipeline::new(context, "sky", &description)? })
    }

    /// Records the stage: the whole scene but for the stars, as radiance. Alpha of the ground counts, too.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        ground: Ground<'a>,
        water: &'a ImageView,
    ) -> Result<&'a ImageView> {
        let scene = shared.targets.scene.view();
        commands.ready(&[ground.depth, ground.color, water].map(|view| view.to(Access::Sampled)))?;
        commands.ready(&[scene.anew(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: scene, clear: Some([0.0; 4]) }], None)?;
        let own = [
            shared.light(),
            ("View", Resource::Storage(shared.buffers.view())),
            shared.pixels("depth", ground.depth),
            shared.pixels("ground", ground.color),
            shared.pixels("scene", water),
        ];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        commands.bind(&self.pipeline, &[own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat())?;
        commands.draw(3, 1)?;
        commands.end_rendering()?;
        Ok(scene)
    }
}
