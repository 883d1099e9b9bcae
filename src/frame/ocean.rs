//! Stage `ocean`: the classes of pixels, and the sea surface over the ground that lies under water. Shaders: `classify.frag`,
//! `ocean.frag`.

use super::classes::{self, Class, ClassPass};
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, Commands, Context, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's passes.
pub(super) struct Ocean {
    /// Without clouds, and with.
    classify: [ClassPass; 2],
    sea: ClassPass,
}

impl Ocean {
    /// Builds their pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        let pass = |name, shader, class| ClassPass::new(context, name, shader, RADIANCE_FORMAT, class);
        let classify = |name, cloudy| pass(name, (shaders::CLASSIFY_FRAG, cloudy), Class::Noted);
        Ok(Ocean {
            classify: [classify("classify", false)?, classify("classify with clouds", true)?],
            sea: pass("ocean", (shaders::OCEAN_FRAG, false), Class::Sea)?,
        })
    }

    /// Records the stage: ground and sea, as radiance.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, ground: Ground<'a>) -> Result<&'a ImageView> {
        let (targets, air, clouds) = (shared.targets, shared.air, shared.scene.clouds());
        let water = targets.water.view();
        let own = [shared.shading(), shared.pixels("depth", ground.depth), shared.pixels("ground", ground.color)];
        let view = [("View", Resource::Storage(shared.buffers.view())), shared.pixels("edges", ground.edges)];
        commands.ready(&[ground.depth, ground.color, ground.edges].map(|view| view.to(Access::Sampled)))?;
        classes::begin(commands, water, targets.classes.view(), false)?;
        let classify = &self.classify[usize::from(shared.has_clouds())];
        classify.draw(commands, &[own.as_slice(), &view, &clouds.bound()].concat())?;
        if shared.has_sea() {
            let resources = [own.as_slice(), &[shared.tiles.waves()], &air.light(), &air.eye(), &clouds.bound()].concat();
            self.sea.draw(commands, &resources)?;
        }
        commands.end_rendering()?;
        Ok(water)
    }
}
