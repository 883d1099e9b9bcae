//! Stage `edges`: where pixels show two surfaces, and how much of the other one. With several samples a pixel from these, of which one
//! goes on: `edges.frag`. With one, from the shape of the edges: `edge_bits.comp` finds them, `edge_shares.comp` measures.

use super::fullscreen::Fullscreen;
use super::passed::{Drawn, Ground, Shared};
use super::targets::{DEPTH_FORMAT, EDGE_FORMAT, RADIANCE_FORMAT};
use crate::shaders;
use crate::vulkan::{
    vk, Access, Buffer, Commands, ComputePipeline, Context, DepthTest, Image, Memory, Resource, Result, Usage,
};
use std::sync::Arc;

/// Pixels of a row in a word of bits: images of edges that are written by words are whole words wide.
pub(super) const WORD: u32 = 32;

/// Kinds of edges, as in `edge_planes.glsl`.
const PLANES: u64 = 6;

/// Rows that an invocation of `edge_bits.comp` looks at.
const ROWS: u32 = 4;

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

/// The stage's pass.
pub(super) enum Edges {
    /// From several samples a pixel.
    Samples(Fullscreen),
    /// From one.
    Shapes(ComputePipeline, ComputePipeline),
}

/// What the stage keeps for pictures of one size with one sample a pixel.
pub(super) struct EdgeBuffers {
    /// One bit a pixel and kind of edge.
    bits: Buffer,
    /// The image of edges, before it is copied there.
    notes: Buffer,
}

impl EdgeBuffers {
    /// Buffers for an image of edges.
    pub(super) fn new(context: &Arc<Context>, edges: &Image) -> Result<EdgeBuffers> {
        let (width, height) = edges.size();
        let words = u64::from(width / WORD) * u64::from(height);
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER, Memory::Device);
        Ok(EdgeBuffers { bits: buffer("edge bits", 4 * PLANES * words)?, notes: buffer("edge notes", u64::from(WORD) * words)? })
    }
}

impl Edges {
    /// Builds its pipelines for targets of so many samples.
    pub(super) fn new(context: &Arc<Context>, samples: u32) -> Result<Edges> {
        if samples == 1 {
            let pipeline = |shader| ComputePipeline::new(context, shader, &[]);
            return Ok(Edges::Shapes(pipeline(&shaders::EDGE_BITS_COMP)?, pipeline(&shaders::EDGE_SHARES_COMP)?));
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
        match self {
            Edges::Samples(pass) => reduce(pass, commands, shared, drawn),
            Edges::Shapes(bits, shares) => measure((bits, shares), commands, shared, drawn),
        }
    }
}

/// One sample of several.
fn reduce<'a>(pass: &Fullscreen, commands: &mut Commands, shared: &Shared<'a>, drawn: Drawn<'a>) -> Result<Ground<'a>> {
    let ground = shared.targets.single();
    let samples = [shared.pixels("ground_samples", drawn.color), shared.pixels("depth_samples", drawn.depth)];
    pass.record(commands, &[ground.color, ground.edges], Some(ground.depth), &samples)?;
    Ok(ground)
}

/// The edges of a picture with one sample a pixel.
fn measure<'a>(
    (bits, shares): (&ComputePipeline, &ComputePipeline),
    commands: &mut Commands,
    shared: &Shared<'a>,
    drawn: Drawn<'a>,
) -> Result<Ground<'a>> {
    let edges = &shared.targets.edges;
    let ground = Ground { color: drawn.color, depth: drawn.depth, edges: edges.view() };
    let Some(buffers) = &shared.targets.edge_buffers else { return Ok(ground) };
    let (width, height) = edges.size();
    let found = ("EdgeBits", Resource::Storage(&buffers.bits));
    let color = shared.pixels("ground", drawn.color);

    commands.ready(&[buffers.bits.to(Access::ComputeWrite)])?;
    commands.bind(bits, &[shared.shading(), shared.pixels("depth", drawn.depth), color, found])?;
    commands.dispatch(bits.workgroups(width / WORD * height.div_ceil(ROWS)), 1, 1)?;

    commands.ready(&[buffers.bits.to(Access::ComputeRead), buffers.notes.to(Access::ComputeWrite)])?;
    commands.bind(shares, &[color, found, ("EdgeNotes", Resource::Storage(&buffers.notes))])?;
    commands.dispatch(shares.workgroups(width / WORD * height), 1, 1)?;

    commands.ready(&[buffers.notes.to(Access::TransferRead), edges.view().anew(Access::TransferWrite)])?;
    commands.copy_buffer_to_image((&buffers.notes, 0), edges, &edges.whole(0, 0)?)?;
    Ok(ground)
}
