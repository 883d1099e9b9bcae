//! Stage `edges`: where pixels show two surfaces, and how much of the other one. With several samples a pixel from these, of which one
//! goes on (shader: `edges.frag`); with one from the shapes of the edges.

use super::edge_shapes::{EdgeShapes, Surfaces};
use super::fullscreen::Fullscreen;
use super::passed::{Drawn, Ground, Shared};
use super::targets::{DEPTH_FORMAT, EDGE_FORMAT, RADIANCE_FORMAT};
use crate::shaders;
use crate::vulkan::{vk, Access, Commands, Context, DepthTest, Result};
use std::sync::Arc;

/// Neighbours that a pixel may be mixed with, as in `edges.glsl`.
const NEIGHBOURS: [[i32; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]];

/// Parts that shares are stored in, as in `edges.glsl`.
const SHARE_PARTS: f32 = 32.0;

/// That a pixel is part of another surface, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// How much of the pixel that surface covers, from 0 to 1.
    pub share: f32,
    /// From the pixel to the neighbour that shows it: columns to the right, rows down.
    pub neighbour: [i32; 2],
}

impl Edge {
    /// What a texel of the image of edges says.
    pub(crate) fn decode(code: u8) -> Option<Edge> {
        let code = code.checked_sub(1)?;
        let share = (f32::from(code / 8) + 1.0) / SHARE_PARTS;
        Some(Edge { share, neighbour: NEIGHBOURS[usize::from(code % 8)] })
    }
}

/// The stage's pipelines.
pub(super) enum Edges {
    /// With several samples a pixel.
    Samples(Fullscreen),
    /// With one.
    Shapes(EdgeShapes),
}

impl Edges {
    /// Builds the pipelines for targets of so many samples.
    pub(super) fn new(context: &Arc<Context>, samples: u32) -> Result<Edges> {
        if samples == 1 {
            return Ok(Edges::Shapes(EdgeShapes::new(context)?));
        }
        let formats = [RADIANCE_FORMAT, EDGE_FORMAT];
        let mut description = Fullscreen::description(shaders::EDGES_FRAG, &formats);
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare: vk::CompareOp::ALWAYS, write: true });
        let constants = [(0, samples)];
        description.specialization = &constants;
        Ok(Edges::Samples(Fullscreen::described(context, "edges", &description)?))
    }

    /// Records the stage: one sample a pixel of what was `drawn`, and its edges.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>, drawn: Drawn<'a>) -> Result<Ground<'a>> {
        commands.ready(&[drawn.color, drawn.depth].map(|view| view.to(Access::Sampled)))?;
        let (targets, mut ground) = (shared.targets, shared.targets.single());
        match (self, &targets.edge_buffers) {
            (Edges::Samples(pass), _) => {
                let samples = [shared.pixels("ground_samples", drawn.color), shared.pixels("depth_samples", drawn.depth)];
                pass.record(commands, &[ground.color, ground.edges], Some(ground.depth), &samples)?;
            }
            (Edges::Shapes(shapes), buffers) => {
                (ground.color, ground.depth) = (drawn.color, drawn.depth);
                let (shading, nearest) = (shared.buffers.shading(), &targets.nearest);
                let surfaces = Surfaces { shading, depth: drawn.depth, ground: drawn.color, nearest };
                let buffers = buffers.as_ref().expect("targets of one sample a pixel have them");
                shapes.record(commands, &surfaces, buffers, &targets.edges)?;
            }
        }
        Ok(ground)
    }
}
