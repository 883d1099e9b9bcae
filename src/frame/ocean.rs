//! Stage `ocean`: what each pixel shows, and the sea surface over the ground that lies under water. Shaders: `classify.frag`, `ocean.frag`.

use super::classes::{classify, ClassBit, ClassPass};
use super::fullscreen::Fullscreen;
use super::passed::{Ground, Shared};
use super::targets::RADIANCE_FORMAT;
use crate::shaders;
use crate::vulkan::{Access, ColorTarget, Commands, Context, DepthTarget, ImageView, Resource, Result};
use std::sync::Arc;

/// The stage's passes.
pub(super) struct Ocean {
    classify: Fullscreen,
    sea: ClassPass,
}

impl Ocean {
    /// Builds their pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Ocean> {
        let sea = ClassPass::new(context, "ocean", (shaders::OCEAN_FRAG, &[]), RADIANCE_FORMAT, (ClassBit::Sea, true))?;
        Ok(Ocean { classify: classify(context, RADIANCE_FORMAT)?, sea })
    }

    /// Records the stage: ground and sea, as radiance; and the classes of pixels.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, ground: Ground<'a>) -> Result<&'a ImageView> {
        let (water, classes) = (shared.targets.water.view(), shared.targets.classes.view());
        let own = [shared.shading(), shared.pixels("depth", ground.depth), shared.pixels("ground", ground.color)];
        let (air, clouds) = (shared.air, shared.scene.clouds());
        let view = [("View", Resource::Storage(shared.buffers.view())), shared.pixels("edges", ground.edges)];
        let found = [own.as_slice(), &view, &clouds.bound()].concat();
        let lit = [own.as_slice(), &[shared.tiles.waves()], &air.light(), &air.eye(), &clouds.bound()].concat();
        commands.ready(&[ground.depth, ground.color, ground.edges].map(|view| view.to(Access::Sampled)))?;
        commands.ready(&[water.anew(Access::ColorTarget), classes.anew(Access::DepthTarget)])?;
        let (color, depth) =
            (ColorTarget { view: water, clear: Some([0.0; 4]) }, DepthTarget { view: classes, clear: Some(0.0) });
        commands.begin_rendering(&[color], Some(depth))?;
        self.classify.draw(commands, 1, &found)?;
        if shared.has_sea() {
            self.sea.draw(commands, &lit)?;
        }
        commands.end_rendering()?;
        Ok(water)
    }
}
