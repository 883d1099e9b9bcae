//! Stage `tonemap`: from radiance to 8 bits a channel. Shader: `tonemap.frag`.

use super::buffers::FrameBuffers;
use super::meter::Meter;
use super::targets::Targets;
use crate::shaders;
use crate::vulkan::{
    vk, Access, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Resource, Result,
};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Tonemap {
    pipeline: GraphicsPipeline,
}

impl Tonemap {
    /// Builds the pipeline for pictures of a format (an UNORM one: the shader encodes sRGB itself).
    pub(super) fn new(context: &Arc<Context>, format: vk::Format) -> Result<Tonemap> {
        let formats = [format];
        let description = GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(shaders::TONEMAP_FRAG), &formats);
        Ok(Tonemap { pipeline: GraphicsPipeline::new(context, "tonemap", &description)? })
    }

    /// Records the stage: reads `targets.scene`, fills `picture`.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        buffers: &FrameBuffers,
        targets: &Targets,
        meter: &Meter,
        picture: &ImageView,
    ) -> Result<()> {
        commands.ready(&[
            meter.factor().to(Access::GraphicsRead),
            targets.scene.view().to(Access::Sampled),
            targets.edges.view().to(Access::Sampled),
            picture.anew(Access::ColorTarget),
        ])?;
        commands.begin_rendering(&[ColorTarget { view: picture, clear: Some([0.0; 4]) }], None)?;
        commands.bind(
            &self.pipeline,
            &[
                ("Light", Resource::Storage(buffers.shading())),
                ("Exposure", Resource::Storage(meter.factor())),
                ("scene", Resource::Sampled(targets.scene.view(), &targets.nearest)),
                ("edges", Resource::Sampled(targets.edges.view(), &targets.nearest)),
            ],
        )?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
