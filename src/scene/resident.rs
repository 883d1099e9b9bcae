//! One patch on the GPU: vertices and triangle lists in one buffer, read by address.

use crate::vulkan::{Buffer, Context, Memory, Result, Upload, Usage};
use std::sync::Arc;
use terrane_planet::lattice::LatticeBox;
use terrane_planet::layout::PatchVertex;
use terrane_planet::progressive::IndexLevel;
use terrane_planet::verify::{LoadedPatch, Reach};

/// Bytes of a triangle: three 16-bit places and padding.
const TRIANGLE_BYTES: u64 = 8;

/// Bytes that a patch of `cells` cells a side takes, about: its vertices, and the triangles of all index levels, twice the finest.
pub(super) fn bytes_of_patch(cells: u32) -> u64 {
    let (cells, row) = (u64::from(cells), u64::from(cells) + 1);
    row * row * size_of::<PatchVertex>() as u64 + 4 * cells * cells * TRIANGLE_BYTES
}

/// A patch that can be drawn.
pub struct ResidentPatch {
    /// Box around its own vertices.
    pub bounds: LatticeBox,
    /// Layer of its textures.
    pub layer: Option<u32>,
    /// Number of the latest frame that used it.
    pub last_used: u64,
    reach: Reach,
    buffer: Buffer,
    triangles: u64,
}

impl ResidentPatch {
    /// Stages a loaded patch for upload.
    pub(super) fn new(
        context: &Arc<Context>,
        upload: &mut Upload,
        patch: &LoadedPatch,
        layer: Option<u32>,
        frame: u64,
    ) -> Result<ResidentPatch> {
        let triangles: Vec<[u32; 2]> =
            patch.lists.triangles.iter().map(|&[a, b, c]| [u32::from(a) | u32::from(b) << 16, u32::from(c)]).collect();
        let start = (size_of::<PatchVertex>() * patch.vertices.len()).next_multiple_of(16) as u64;
        let bytes = start + TRIANGLE_BYTES * triangles.len() as u64;
        let buffer = Buffer::new(context, &format!("patch {}", patch.mesh.id), bytes, Usage::STORAGE_BUFFER, Memory::Device)?;
        upload.buffer(&buffer, 0, &patch.vertices)?;
        upload.buffer(&buffer, start, &triangles)?;
        Ok(ResidentPatch {
            bounds: patch.mesh.bounds,
            layer,
            last_used: frame,
            reach: patch.reach.clone(),
            buffer,
            triangles: start,
        })
    }

    /// See [`Reach::level_for`].
    pub fn level_for(&self, distance: f64, reach: f64) -> IndexLevel {
        self.reach.level_for(distance, reach)
    }

    /// Device address of its vertices.
    pub fn vertices_address(&self) -> u64 {
        self.buffer.device_address()
    }

    /// Device address of the triangles of one of its levels.
    pub fn triangles_address(&self, level: IndexLevel) -> u64 {
        self.buffer.device_address() + self.triangles + TRIANGLE_BYTES * u64::from(level.first)
    }

    /// Its buffer, to be kept alive while a frame uses it.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}
