//! Stage `tonemap`: from radiance to 8 bits a channel. Shader: `tonemap.frag`.

use super::classes::{self, Class, ClassPass};
use super::passed::Shared;
use crate::shaders;
use crate::vulkan::{vk, Access, Buffer, Commands, Context, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's passes: all pixels without edges, and those on edges once more.
pub(super) struct Tonemap {
    plain: ClassPass,
    mixed: ClassPass,
}

impl Tonemap {
    /// Builds their pipelines for pictures of a format (an UNORM one: the shader encodes sRGB itself).
    pub(super) fn new(context: &Arc<Context>, format: vk::Format) -> Result<Tonemap> {
        let pass = |name, mixed, class| ClassPass::new(context, name, (shaders::TONEMAP_FRAG, mixed), format, class);
        Ok(Tonemap { plain: pass("tonemap", 0, Class::Any)?, mixed: pass("tonemap edges", 1, Class::Edge)? })
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
        let metered = ("Exposure", Resource::Uniform(metered));
        let resources = [shared.shading(), metered, shared.pixels("radiance", radiance), shared.pixels("edges", edges)];
        classes::begin(commands, picture, shared.targets.classes.view(), true)?;
        self.plain.draw(commands, &resources)?;
        self.mixed.draw(commands, &resources)?;
        commands.end_rendering()
    }
}
