//! Replays a patch's collapses to recover the neighbourhoods they happened in, for checks and for study.

use super::patch_mesh::PatchMesh;
use terrane_heightfield::decimate::mesh::Mesh;

/// Ring of every vertex at the time it collapses, as vertex indices (empty for vertices that never do).
///
/// Collapsing in reverse wake order gives the same rings as the builder's own order, since a wake order is another order of the
/// same dependencies; `None` if a record does not fit that (a damaged or foreign hierarchy).
pub fn rings(mesh: &PatchMesh) -> Option<Vec<Vec<u16>>> {
    let side = mesh.cells as usize + 1;
    let mut connectivity = Mesh::grid(side, side);
    let mut index_of = vec![0u16; mesh.vertices.len()];
    for (k, vertex) in mesh.vertices.iter().enumerate() {
        *index_of.get_mut(usize::from(vertex.grid))? = k as u16;
    }
    let mut rings = vec![Vec::new(); mesh.vertices.len()];
    let (mut ring, mut star) = (Vec::new(), Vec::new());
    for (k, vertex) in mesh.vertices.iter().enumerate().rev() {
        if usize::from(vertex.parent) == k {
            continue;
        }
        let v = u32::from(vertex.grid);
        let into = u32::from(mesh.vertices.get(usize::from(vertex.parent))?.grid);
        connectivity.walk(v, &mut star, &mut ring);
        if !ring.contains(&into) {
            return None;
        }
        rings[k] = ring.iter().map(|&r| index_of[r as usize]).collect();
        connectivity.collapse(v, into, &mut star);
    }
    Some(rings)
}
