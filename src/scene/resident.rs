//! One patch on the GPU: vertices and triangle lists in one buffer, read by address.

use crate::vulkan::{Buffer, Context, Memory, Result, Upload, Usage};
use std::sync::Arc;
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::draw::work::{Reach, Work};

/// Bytes of a triangle: three 16-bit vertex indices.
const TRIANGLE_BYTES: u64 = 6;

/// Bytes that a patch of `cells` cells a side takes, about: its vertices, and the triangles of all index levels, 2.75 times the finest.
pub(super) fn bytes_of_patch(cells: u32) -> u64 {
    let (cells, row) = (u64::from(cells), u64::from(cells) + 1);
    row * row * size_of::<PatchVertex>() as u64 + 11 * cells * cells * TRIANGLE_BYTES / 2
}

/// What is on the GPU of a patch: its mesh, its textures, or both.
#[derive(Default)]
pub struct ResidentPatch {
    /// Its mesh, without which it cannot be drawn.
    pub mesh: Option<ResidentMesh>,
    /// Slot of its textures.
    pub slot: Option<u32>,
    /// Number of the latest frame that used it.
    pub last_used: u64,
    /// Number of the sun that its light is of.
    pub(super) sun: u64,
}

/// A mesh that can be drawn.
pub struct ResidentMesh {
    reach: Reach,
    buffer: Buffer,
    triangles: u64,
}

impl ResidentMesh {
    /// Stages a loaded patch for upload.
    pub(super) fn new(context: &Arc<Context>, upload: &mut Upload, patch: &LoadedPatch) -> Result<ResidentMesh> {
        let triangles = &patch.lists.triangles;
        let start = (size_of::<PatchVertex>() * patch.vertices.len()).next_multiple_of(16) as u64;
        // Emission reads whole words.
        let bytes = start + (TRIANGLE_BYTES * triangles.len() as u64).next_multiple_of(4);
        let buffer = Buffer::new(context, &format!("patch {}", patch.mesh.id), bytes, Usage::STORAGE_BUFFER, Memory::Device)?;
        upload.buffer(&buffer, 0, &patch.vertices)?;
        upload.buffer(&buffer, start, triangles)?;
        Ok(ResidentMesh { reach: patch.reach.clone(), buffer, triangles: start })
    }

    /// What a view looks at.
    pub fn work(&self, view: &View) -> Work {
        self.reach.work(view)
    }

    /// Device address of its vertices.
    pub fn vertices_address(&self) -> u64 {
        self.buffer.device_address()
    }

    /// Device address of the triangles of all its levels.
    pub fn triangles_address(&self) -> u64 {
        self.buffer.device_address() + self.triangles
    }

    /// Its buffer, to be kept alive while a frame uses it.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}
