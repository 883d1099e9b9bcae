//! Stage `stars`: points of light behind everything, added to the finished sky. Shaders: `stars.comp` finds where they are and how
//! bright, once each; `stars.vert`, `stars.frag` draw them.

use super::passed::Shared;
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{
    vk, Access, Blend, Buffer, ColorTarget, Commands, ComputePipeline, Context, GraphicsDescription, GraphicsPipeline, ImageView,
    Memory, Resource, Result, Usage,
};
use std::sync::Arc;
use terrane_planet::draw::layout::{Star, STARS};

/// The stage's pipelines, and this frame's stars.
pub(super) struct Stars {
    find: ComputePipeline,
    draw: GraphicsPipeline,
    stars: Buffer,
}

impl Stars {
    /// Builds the pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Stars> {
        let formats = [RADIANCE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::STARS_VERT, Some(shaders::STARS_FRAG), &formats);
        description.blend = Blend::Add;
        description.topology = vk::PrimitiveTopology::TRIANGLE_STRIP;
        let bytes = u64::from(STARS) * size_of::<Star>() as u64;
        Ok(Stars {
            find: ComputePipeline::new(context, &shaders::STARS_COMP, &[])?,
            draw: GraphicsPipeline::new(context, "stars", &description)?,
            stars: Buffer::new(context, "stars", bytes, Usage::STORAGE_BUFFER, Memory::Device)?,
        })
    }

    /// Records the stage: adds to `radiance` where `depth` has nothing.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        depth: &'a ImageView,
        radiance: &'a ImageView,
    ) -> Result<()> {
        let stars = ("Stars", Resource::Storage(&self.stars));
        commands.ready(&[self.stars.to(Access::ComputeWrite)])?;
        let (eye, clouds) = (shared.air.eye(), shared.scene.clouds().bound());
        commands.bind(&self.find, &[[shared.shading(), stars].as_slice(), &eye, &clouds].concat())?;
        commands.dispatch(STARS.div_ceil(self.find.workgroup_size()[0]), 1, 1)?;
        commands.ready(&[self.stars.to(Access::GraphicsRead), depth.to(Access::Sampled), radiance.to(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: radiance, clear: None }], None)?;
        commands.bind(&self.draw, &[shared.shading(), stars, shared.pixels("depth", depth)])?;
        commands.draw(4, STARS)?;
        commands.end_rendering()
    }
}
