//! Stage `sky`: the air between the eye and everything, and what is behind it. Shader: `sky.frag`.

use super::fullscreen::Fullscreen;
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, Commands, Context, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's pass.
pub(super) struct Sky {
    pass: Fullscreen,
}

impl Sky {
    /// Builds its pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Sky> {
        Ok(Sky { pass: Fullscreen::new(context, "sky", shaders::SKY_FRAG, RADIANCE_FORMAT)? })
    }

    /// Records the stage: the whole scene but for the stars, as radiance. Alpha of the ground counts, too.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        ground: Ground<'a>,
        water: &'a ImageView,
    ) -> Result<&'a ImageView> {
        let radiance = shared.targets.radiance.view();
        commands.ready(&[ground.depth, ground.color, water].map(|view| view.to(Access::Sampled)))?;
        let own = [
            shared.shading(),
            ("View", Resource::Storage(shared.buffers.view())),
            shared.pixels("depth", ground.depth),
            shared.pixels("ground", ground.color),
            shared.pixels("water", water),
        ];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        let resources = [own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat();
        self.pass.record(commands, &[radiance], None, &resources)?;
        Ok(radiance)
    }
}
