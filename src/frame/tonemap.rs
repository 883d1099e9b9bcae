//! Stage `tonemap`: from radiance to 8 bits a channel. Shader: `tonemap.frag`.

use super::passed::Shared;
use crate::shaders;
use crate::vulkan::{
    vk, Access, Buffer, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Resource, Result,
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

    /// Records the stage: from `scene`, with the exposure that was metered, to `picture`; pixels on `edges` are mixed with their
    /// neighbours.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        (scene, edges): (&'a ImageView, &'a ImageView),
        metered: &'a Buffer,
        picture: &ImageView,
    ) -> Result<()> {
        commands.ready(&[scene, edges].map(|view| view.to(Access::Sampled)))?;
        commands.ready(&[metered.to(Access::GraphicsRead), picture.anew(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: picture, clear: Some([0.0; 4]) }], None)?;
        let metered = ("Exposure", Resource::Storage(metered));
        let resources = [shared.light(), metered, shared.pixels("scene", scene), shared.pixels("edges", edges)];
        commands.bind(&self.pipeline, &resources)?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
