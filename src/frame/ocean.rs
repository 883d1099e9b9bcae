//! Stage `ocean`: the sea surface over the ground that lies under water. Shader: `ocean.frag`.

use super::passed::{Ground, Shared};
use super::targets::SCENE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Result};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Ocean {
    pipeline: GraphicsPipeline,
}

impl Ocean {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        let formats = [SCENE_FORMAT];
        let description = GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(shaders::OCEAN_FRAG), &formats);
        Ok(Ocean { pipeline: GraphicsPipeline::new(context, "ocean", &description)? })
    }

    /// Records the stage: ground and sea, as radiance.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, ground: Ground<'a>) -> Result<&'a ImageView> {
        let water = shared.targets.water.view();
        commands.ready(&[ground.depth, ground.color].map(|view| view.to(Access::Sampled)))?;
        commands.ready(&[water.anew(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: water, clear: Some([0.0; 4]) }], None)?;
        let own =
            [shared.light(), shared.pixels("depth", ground.depth), shared.pixels("ground", ground.color), shared.tiles.waves()];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        commands.bind(&self.pipeline, &[own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat())?;
        commands.draw(3, 1)?;
        commands.end_rendering()?;
        Ok(water)
    }
}
