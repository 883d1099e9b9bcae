//! Stage `stars`: points of light behind everything, added to the finished sky. Shaders: `stars.vert`, `stars.frag`.

use super::air::Air;
use super::buffers::FrameBuffers;
use super::targets::{Targets, SCENE_FORMAT};
use crate::scene::CloudMaps;
use crate::shaders;
use crate::vulkan::{vk, Access, Blend, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, Resource, Result};
use std::sync::Arc;
use terrane_planet::draw::layout::STARS;

/// The stage's pipeline.
pub(super) struct Stars {
    pipeline: GraphicsPipeline,
}

impl Stars {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Stars> {
        let formats = [SCENE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::STARS_VERT, Some(shaders::STARS_FRAG), &formats);
        description.blend = Blend::Add;
        description.topology = vk::PrimitiveTopology::TRIANGLE_STRIP;
        Ok(Stars { pipeline: GraphicsPipeline::new(context, "stars", &description)? })
    }

    /// Records the stage: adds to `targets.scene` where `targets.depth` has nothing.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        buffers: &FrameBuffers,
        clouds: &CloudMaps,
        targets: &Targets,
        air: &Air,
    ) -> Result<()> {
        commands.ready(&[targets.depth.view().to(Access::Sampled), targets.scene.view().to(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: targets.scene.view(), clear: None }], None)?;
        let own = [
            ("Light", Resource::Storage(buffers.shading())),
            ("depth", Resource::Sampled(targets.depth.view(), &targets.nearest)),
        ];
        commands.bind(&self.pipeline, &[own.as_slice(), &air.eye(), &clouds.bound()].concat())?;
        commands.draw(4, STARS)?;
        commands.end_rendering()
    }
}
