//! Stage `ocean`: the sea surface over the ground that lies under water. Shader: `ocean.frag`.

use super::air::Air;
use super::buffers::FrameBuffers;
use super::targets::{Targets, SCENE_FORMAT};
use super::tiles::Tiles;
use crate::scene::CloudMaps;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, Resource, Result};
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

    /// Records the stage: reads `targets.ground` and `targets.depth`, fills `targets.water`.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        buffers: &FrameBuffers,
        clouds: &CloudMaps,
        targets: &Targets,
        air: &Air,
        tiles: &Tiles,
    ) -> Result<()> {
        commands.ready(&[
            targets.depth.view().to(Access::Sampled),
            targets.ground.view().to(Access::Sampled),
            targets.water.view().anew(Access::ColorTarget),
        ])?;
        commands.begin_rendering(&[ColorTarget { view: targets.water.view(), clear: Some([0.0; 4]) }], None)?;
        let own = [
            ("Light", Resource::Storage(buffers.shading())),
            ("depth", Resource::Sampled(targets.depth.view(), &targets.nearest)),
            ("ground", Resource::Sampled(targets.ground.view(), &targets.nearest)),
            tiles.waves(),
        ];
        commands.bind(&self.pipeline, &[own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat())?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
