//! Stage `stars`: points of light behind everything, added to the finished sky. Shaders: `stars.vert`, `stars.frag`.

use super::passed::Shared;
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{
    vk, Access, Blend, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Result,
};
use std::sync::Arc;
use terrane_planet::draw::layout::STARS;

/// The stage's pipeline.
pub(super) struct Stars {
    pipeline: GraphicsPipeline,
}

impl Stars {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Stars> {
        let formats = [RADIANCE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::STARS_VERT, Some(shaders::STARS_FRAG), &formats);
        description.blend = Blend::Add;
        description.topology = vk::PrimitiveTopology::TRIANGLE_STRIP;
        Ok(Stars { pipeline: GraphicsPipeline::new(context, "stars", &description)? })
    }

    /// Records the stage: adds to `radiance` where `depth` has nothing.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        depth: &'a ImageView,
        radiance: &'a ImageView,
    ) -> Result<()> {
        commands.ready(&[depth.to(Access::Sampled), radiance.to(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: radiance, clear: None }], None)?;
        let own = [shared.shading(), shared.pixels("depth", depth)];
        commands.bind(&self.pipeline, &[own.as_slice(), &shared.air.eye(), &shared.scene.clouds().bound()].concat())?;
        commands.draw(4, STARS)?;
        commands.end_rendering()
    }
}
