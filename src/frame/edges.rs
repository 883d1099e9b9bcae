//! Stage `edges`: one sample of the ground a pixel from several, and where the others show something else. Shader: `edges.frag`.

use super::fullscreen::Fullscreen;
use super::passed::{Drawn, Ground, Shared};
use super::targets::{DEPTH_FORMAT, EDGE_FORMAT, RADIANCE_FORMAT};
use crate::shaders;
use crate::vulkan::{vk, Access, ColorTarget, Commands, Context, DepthTest, Result};
use std::sync::Arc;

/// The stage's pass.
pub(super) struct Edges {
    pass: Fullscreen,
}

impl Edges {
    /// Builds its pipeline for targets of so many samples.
    pub(super) fn new(context: &Arc<Context>, samples: u32) -> Result<Edges> {
        let formats = [RADIANCE_FORMAT, EDGE_FORMAT];
        let mut description = Fullscreen::description(shaders::EDGES_FRAG, &formats);
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare: vk::CompareOp::ALWAYS, write: true });
        let constants = [(0, samples)];
        description.specialization = &constants;
        Ok(Edges { pass: Fullscreen::described(context, "edges", &description)? })
    }

    /// Records the stage: one sample of what was `drawn` with several.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, drawn: Drawn<'a>) -> Result<Ground<'a>> {
        let ground = shared.targets.single();
        commands.ready(&[drawn.color, drawn.depth].map(|view| view.to(Access::Sampled)))?;
        let samples = [shared.pixels("ground_samples", drawn.color), shared.pixels("depth_samples", drawn.depth)];
        self.pass.record(commands, &[ground.color, ground.edges], Some(ground.depth), &samples)?;
        Ok(ground)
    }

    /// In place of the stage where one sample a pixel was `drawn`: there are no edges.
    pub(super) fn record_none<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, drawn: Drawn<'a>) -> Result<Ground<'a>> {
        let edges = shared.targets.edges.view();
        commands.ready(&[edges.anew(Access::ColorTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: edges, clear: Some([0.0; 4]) }], None)?;
        commands.end_rendering()?;
        Ok(Ground { color: drawn.color, depth: drawn.depth, edges })
    }
}
