//! Stage `ocean`: the sea surface blended over the ground, by its distance against the ground's depth. Shader: `ocean.frag`.

use super::buffers::FrameBuffers;
use super::targets::{Targets, SCENE_FORMAT};
use crate::shaders;
use crate::vulkan::{Blend, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, Resource, Result};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Ocean {
    pipeline: GraphicsPipeline,
}

impl Ocean {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        let formats = [SCENE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(shaders::OCEAN_FRAG), &formats);
        description.blend = Blend::Premultiplied;
        Ok(Ocean { pipeline: GraphicsPipeline::new(context, "ocean", &description)? })
    }

    /// Records the stage: reads `targets.depth`, blends into `targets.ground`.
    pub(super) fn record(&self, commands: &mut Commands, buffers: &FrameBuffers, targets: &Targets) -> Result<()> {
        commands.begin_rendering(&[ColorTarget { view: targets.ground.view(), clear: None }], None)?;
        commands.bind(
            &self.pipeline,
            &[
                ("Light", Resource::Storage(buffers.shading())),
                ("View", Resource::Storage(buffers.view())),
                ("depth", Resource::Sampled(targets.depth.view(), &targets.nearest)),
            ],
        )?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
