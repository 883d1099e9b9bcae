//! Stage `ocean`: the sea surface over the ground that lies under water. Shader: `ocean.frag`.

use super::fullscreen::Fullscreen;
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, Commands, Context, ImageView, Result};
use std::sync::Arc;

/// The stage's pass.
pub(super) struct Ocean {
    pass: Fullscreen,
}

impl Ocean {
    /// Builds its pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        Ok(Ocean { pass: Fullscreen::new(context, "ocean", shaders::OCEAN_FRAG, RADIANCE_FORMAT)? })
    }

    /// Records the stage: ground and sea, as radiance.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, ground: Ground<'a>) -> Result<&'a ImageView> {
        let water = shared.targets.water.view();
        commands.ready(&[ground.depth, ground.color].map(|view| view.to(Access::Sampled)))?;
        let own =
            [shared.shading(), shared.pixels("depth", ground.depth), shared.pixels("ground", ground.color), shared.tiles.waves()];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        let resources = [own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat();
        self.pass.record(commands, &[water], None, &resources)?;
        Ok(water)
    }
}
