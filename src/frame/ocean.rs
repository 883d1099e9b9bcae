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
    /// By what is asked: whether there are clouds (1), and rays without air (2).
    classify: [ClassPass; 4],
    sea: ClassPass,
}

impl Ocean {
    /// Builds their pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        let pass = |name, shader, class| ClassPass::new(context, name, shader, RADIANCE_FORMAT, class);
        let classify = |asked| pass("classify", (shaders::CLASSIFY_FRAG, asked), Class::Noted);
        Ok(Ocean {
            classify: [classify(0)?, classify(1)?, classify(2)?, classify(3)?],
            sea: pass("ocean", (shaders::OCEAN_FRAG, 0), Class::Sea)?,
        })
    }

    /// Records the stage: ground and sea, as radiance.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, ground: Ground<'a>) -> Result<&'a ImageView> {
        let (targets, air, clouds) = (shared.targets, shared.air, shared.scene.clouds());
        let water = targets.water.view();
        let own = [shared.shading(), shared.pixels("depth", ground.depth), shared.pixels("ground", ground.color)];
        let view = [("View", Resource::Uniform(shared.buffers.view())), shared.pixels("edges", ground.edges)];
        commands.ready(&[ground.depth, ground.color, ground.edges].map(|view| view.to(Access::Sampled)))?;
        classes::begin(commands, water, targets.classes.view(), false)?;
        let classify = &self.classify[usize::from(shared.has_clouds()) + 2 * usize::from(shared.has_space())];
        classify.draw(commands, &[own.as_slice(), &view, &clouds.bound()].concat())?;
        if shared.has_sea() {
            let resources = [own.as_slice(), &[shared.tiles.waves()], &air.light(), &air.eye(), &clouds.bound()].concat();
            self.sea.draw(commands, &resources)?;
        }
        commands.end_rendering()?;
        Ok(water)
    }
}
