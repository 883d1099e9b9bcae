//! Stage `upscale`: from a picture drawn with fewer pixels to one of all of them. Shader: `upscale.frag`.

use super::fullscreen::Fullscreen;
use super::targets::Targets;
use crate::shaders;
use crate::vulkan::{vk, Access, ColorTarget, Commands, Context, GraphicsPipeline, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's pass.
pub(super) struct Upscale {
    pipeline: GraphicsPipeline,
}

impl Upscale {
    /// Builds its pipeline for pictures of a format.
    pub(super) fn new(context: &Arc<Context>, format: vk::Format) -> Result<Upscale> {
        let formats = [format];
        let description = Fullscreen::description(shaders::UPSCALE_FRAG, &formats);
        Ok(Upscale { pipeline: GraphicsPipeline::new(context, "upscale", &description)? })
    }

    /// Records the stage: from `few`, of the targets' size, to every pixel of `picture`.
    pub(super) fn record(&self, commands: &mut Commands, targets: &Targets, few: &ImageView, picture: &ImageView) -> Result<()> {
        commands.ready(&[few.to(Access::Sampled), picture.anew(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: picture, clear: None }], None)?;
        commands.bind(&self.pipeline, &[("few", Resource::Sampled(few, &targets.nearest))])?;
        let ((width, height), (wide, high)) = (few.size(), picture.size());
        commands.push_constants(&[width as f32 / wide as f32, height as f32 / high as f32])?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
