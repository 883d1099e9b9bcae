//! Twin of `resolve.comp`: the vertex that each vertex of a patch is drawn as.

use crate::draw::layout::PatchVertex;

/// Whether bit `k` is set.
#[inline]
pub fn bit(awake: &[u32], k: u32) -> bool {
    awake[(k / 32) as usize] >> (k % 32) & 1 == 1
}

/// First awake ancestor of every vertex: itself, if it is awake. The chain ends at a vertex that never sleeps, or at one
/// that names itself.
pub fn resolve(vertices: &[PatchVertex], awake: &[u32]) -> Vec<u32> {
    let first_awake = |k: usize| {
        let mut at = k as u32;
        while !bit(awake, at) && vertices[at as usize].parent() != at {
            at = vertices[at as usize].parent();
        }
        at
    };
    (0..vertices.len()).map(first_awake).collect()
}
