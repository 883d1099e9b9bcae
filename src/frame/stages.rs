//! All stages of a frame as one value, so that all can be built again at a time.

use super::air::Air;
use super::draw::Draw;
use super::edges::Edges;
use super::emit::Emit;
use super::meter::Meter;
use super::ocean::Ocean;
use super::resolve::Resolve;
use super::select::Select;
use super::sky::Sky;
use super::stars::Stars;
use super::tiles::Tiles;
use super::tonemap::Tonemap;
use super::upscale::Upscale;
use crate::vulkan::{vk, Context, Result};
use std::sync::Arc;

/// The stages, each with its pipelines and what it keeps.
pub(super) struct Stages {
    pub(super) select: Select,
    pub(super) resolve: Resolve,
    pub(super) emit: Emit,
    pub(super) air: Air,
    pub(super) draw: Draw,
    pub(super) edges: Edges,
    pub(super) ocean: Ocean,
    pub(super) sky: Sky,
    pub(super) stars: Stars,
    pub(super) meter: Meter,
    pub(super) tonemap: Tonemap,
    pub(super) upscale: Upscale,
    pub(super) tiles: Tiles,
}

impl Stages {
    /// Builds the stages for pictures of a format, of ground with so many samples a pixel.
    pub(super) fn new(context: &Arc<Context>, samples: u32, format: vk::Format) -> Result<Stages> {
        Ok(Stages {
            select: Select::new(context)?,
            resolve: Resolve::new(context)?,
            emit: Emit::new(context)?,
            air: Air::new(context)?,
            draw: Draw::new(context, samples)?,
            edges: Edges::new(context, samples)?,
            ocean: Ocean::new(context)?,
            sky: Sky::new(context)?,
            stars: Stars::new(context)?,
            meter: Meter::new(context)?,
            tonemap: Tonemap::new(context, format)?,
            upscale: Upscale::new(context, format)?,
            tiles: Tiles::new(context)?,
        })
    }
}
