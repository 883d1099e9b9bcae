//! Stage `sky`: the air between the eye and everything, and what is behind it. Shader: `sky.frag`.

use super::air::Air;
use super::buffers::FrameBuffers;
use super::targets::{Targets, SCENE_FORMAT};
use crate::scene::CloudMaps;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, Resource, Result};
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

    /// Records the stage: reads `targets.water`, `targets.ground` (for its alpha) and `targets.depth`, fills `targets.scene`.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        buffers: &FrameBuffers,
        clouds: &CloudMaps,
        targets: &Targets,
        air: &Air,
    ) -> Result<()> {
        commands.ready(&[
            targets.depth.view().to(Access::Sampled),
            targets.ground.view().to(Access::Sampled),
            targets.water.view().to(Access::Sampled),
            targets.scene.view().anew(Access::ColorTarget),
        ])?;
        commands.begin_rendering(&[ColorTarget { view: targets.scene.view(), clear: Some([0.0; 4]) }], None)?;
        let own = [
            ("Light", Resource::Storage(buffers.shading())),
            ("View", Resource::Storage(buffers.view())),
            ("depth", Resource::Sampled(targets.depth.view(), &targets.nearest)),
            ("ground", Resource::Sampled(targets.ground.view(), &targets.nearest)),
            ("scene", Resource::Sampled(targets.water.view(), &targets.nearest)),
        ];
        commands.bind(&self.pipeline, &[own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat())?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
