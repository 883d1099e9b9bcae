//! Stage `tonemap`: from radiance to 8 bits a channel. Shader: `tonemap.frag`.

use super::fullscreen::Fullscreen;
use super::passed::Shared;
use crate::shaders;
use crate::vulkan::{vk, Access, Buffer, Commands, Context, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's pass.
pub(super) struct Tonemap {
    pass: Fullscreen,
}

impl Tonemap {
    /// Builds its pipeline for pictures of a format (an UNORM one: the shader encodes sRGB itself).
    pub(super) fn new(context: &Arc<Context>, format: vk::Format) -> Result<Tonemap> {
        Ok(Tonemap { pass: Fullscreen::new(context, "tonemap", shaders::TONEMAP_FRAG, format)? })
    }

    /// Records the stage: from `radiance`, with the exposure that was metered, to `picture`; pixels on `edges` are mixed with their
    /// neighbours.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        (radiance, edges): (&'a ImageView, &'a ImageView),
        metered: &'a Buffer,
        picture: &ImageView,
    ) -> Result<()> {
        commands.ready(&[radiance, edges].map(|view| view.to(Access::Sampled)))?;
        commands.ready(&[metered.to(Access::GraphicsRead)])?;
        let metered = ("Exposure", Resource::Storage(metered));
        let resources = [shared.shading(), metered, shared.pixels("radiance", radiance), shared.pixels("edges", edges)];
        self.pass.record(commands, &[picture], None, &resources)
    }
}
