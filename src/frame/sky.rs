//! Stage `sky`: the air between the eye and everything, and what is behind it. Shader: `sky.frag`.

use super::classes::{self, Class, ClassPass};
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, Commands, Context, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's passes by what lies before a pixel: nothing, clear air, clouds.
pub(super) struct Sky {
    space: ClassPass,
    clear: ClassPass,
    cloudy: ClassPass,
}

impl Sky {
    /// Builds their pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Sky> {
        let pass = |name, before, class| ClassPass::new(context, name, (shaders::SKY_FRAG, before), RADIANCE_FORMAT, class);
        Ok(Sky {
            space: pass("space", 0, Class::Space)?,
            clear: pass("sky", 1, Class::Clear)?,
            cloudy: pass("cloudy sky", 2, Class::Cloudy)?,
        })
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
            ("View", Resource::Uniform(shared.buffers.view())),
            shared.pixels("depth", ground.depth),
            shared.pixels("ground", ground.color),
            shared.pixels("water", water),
        ];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        let resources = [own.as_slice(), &air.light(), &air.eye(), &clouds.bound()].concat();
        classes::begin(commands, radiance, shared.targets.classes.view(), true)?;
        if shared.has_space() {
            self.space.draw(commands, &resources)?;
        }
        self.clear.draw(commands, &resources)?;
        if shared.has_clouds() {
            self.cloudy.draw(commands, &resources)?;
        }
        commands.end_rendering()?;
        Ok(radiance)
    }
}
