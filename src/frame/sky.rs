//! Stage `sky`: the air between the eye and everything, and what is behind it. Shader: `sky.frag`.

use super::classes::{ClassBit, ClassPass};
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, DepthTarget, ImageView, Resource, Result};
use std::sync::Arc;

/// Constant of `sky.frag`.
const CLOUDY: u32 = 0;

/// The stage's passes: where there is no cloud, and where one may be.
pub(super) struct Sky {
    clear: ClassPass,
    cloudy: ClassPass,
}

impl Sky {
    /// Builds their pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Sky> {
        let pass = |name, cloudy| {
            let fragment = (shaders::SKY_FRAG, [(CLOUDY, u32::from(cloudy))]);
            ClassPass::new(context, name, (fragment.0, &fragment.1), RADIANCE_FORMAT, (ClassBit::Clouds, cloudy))
        };
        Ok(Sky { clear: pass("sky", false)?, cloudy: pass("cloudy sky", true)? })
    }

    /// Records the stage: the whole scene but for the stars, as radiance. Alpha of the ground counts, too.
    pub(super) fn record<'a>(
        &self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        ground: Ground<'a>,
        water: &'a ImageView,
    ) -> Result<&'a ImageView> {
        let (radiance, classes) = (shared.targets.radiance.view(), shared.targets.classes.view());
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
        commands.ready(&[radiance.anew(Access::ColorTarget), classes.to(Access::DepthTarget)])?;
        let (color, depth) = (ColorTarget { view: radiance, clear: Some([0.0; 4]) }, DepthTarget { view: classes, clear: None });
        commands.begin_rendering(&[color], Some(depth))?;
        self.clear.draw(commands, &resources)?;
        if shared.has_clouds() {
            self.cloudy.draw(commands, &resources)?;
        }
        commands.end_rendering()?;
        Ok(radiance)
    }
}
