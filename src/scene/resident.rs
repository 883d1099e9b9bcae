//! One patch on the GPU: vertices and triangle lists in one buffer, read by address. A still has those that its view can wake, a twentieth or
//! so of all.

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

/// A mesh that can be drawn, whole or as far as some views need it.
pub struct ResidentMesh {
    reach: Reach,
    buffer: Buffer,
    /// Device address where the triangles of the finest level would begin.
    triangles: u64,
    /// The finest index level that is there: 0 if all of what was loaded is.
    finest: usize,
}

impl ResidentMesh {
    /// Stages a loaded patch for upload, from the index level `finest` on.
    pub(super) fn new(context: &Arc<Context>, upload: &mut Upload, patch: &LoadedPatch, finest: usize) -> Result<ResidentMesh> {
        let (vertices, first) = part(patch, finest);
        let triangles = &patch.lists.triangles[first as usize..];
        let start = start_of_triangles(vertices);
        let bytes = ResidentMesh::bytes_of(patch, finest);
        let buffer = Buffer::new(context, &format!("patch {}", patch.mesh.id), bytes, Usage::STORAGE_BUFFER, Memory::Device)?;
        upload.buffer(&buffer, 0, vertices)?;
        upload.buffer(&buffer, start, triangles)?;
        let triangles = (buffer.device_address() + start).wrapping_sub(TRIANGLE_BYTES * u64::from(first));
        Ok(ResidentMesh { reach: patch.reach.clone(), buffer, triangles, finest })
    }

    /// Bytes that a patch takes from an index level on.
    pub(super) fn bytes_of(patch: &LoadedPatch, finest: usize) -> u64 {
        let (vertices, first) = part(patch, finest);
        // Emission reads whole words.
        start_of_triangles(vertices)
            + (TRIANGLE_BYTES * (patch.lists.triangles.len() as u64 - u64::from(first))).next_multiple_of(4)
    }

    /// Whether all is there that a view can wake.
    pub fn suffices(&self, view: &View) -> bool {
        self.reach.suffices(view) && (self.finest == 0 || self.finest <= self.reach.finest(view))
    }

    /// Whether all of the patch is there.
    pub(super) fn is_whole(&self) -> bool {
        self.finest == 0 && self.reach.is_whole()
    }

    /// What a view looks at, for which it [`suffices`](ResidentMesh::suffices).
    pub fn work(&self, view: &View) -> Work {
        self.reach.work(view)
    }

    /// Device address of its vertices.
    pub fn vertices_address(&self) -> u64 {
        self.buffer.device_address()
    }

    /// Device address from which the triangles of all its levels are counted; those of levels that are not there lie before the buffer.
    pub fn triangles_address(&self) -> u64 {
        self.triangles
    }

    /// Its buffer, to be kept alive while a frame uses it.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}

/// The vertices of a patch from an index level on, and the first of its triangles: an even one, for two of them are three words.
fn part(patch: &LoadedPatch, finest: usize) -> (&[PatchVertex], u32) {
    let level = &patch.lists.levels[finest];
    (&patch.vertices[..level.vertices as usize], level.start() / 2 * 2)
}

fn start_of_triangles(vertices: &[PatchVertex]) -> u64 {
    size_of_val(vertices).next_multiple_of(16) as u64
}
