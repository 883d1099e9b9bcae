//! The surface that a view draws, in one piece.

use super::solid::rim;
use crate::draw::cut::{cut, is_visible, Leaf};
use crate::draw::layout::PatchVertex;
use crate::draw::loaded_patch::LoadedPatch;
use crate::draw::tree::PatchTree;
use crate::draw::view::View;
use crate::globe::patch::PatchId;
use crate::reference::emit::emit;
use crate::reference::resolve::resolve;
use crate::reference::select::select;
use glam::IVec3;
use std::collections::HashMap;
use std::ops::Range;

/// The triangles of a patch within a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The patch.
    pub id: PatchId,
    /// Its triangles.
    pub triangles: Range<usize>,
}

/// Triangles that share vertices: every lattice position is there once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Welded {
    /// Lattice positions, in order of first use.
    pub positions: Vec<IVec3>,
    /// Corners as indices into `positions`, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The finest level of the patches that each position came from.
    pub levels: Vec<u8>,
    /// The patches that triangles came from, in the order of their triangles.
    pub parts: Vec<Part>,
    numbers: HashMap<IVec3, u32>,
}

impl Welded {
    /// Adds the triangles of a patch.
    pub fn add(&mut self, id: PatchId, vertices: &[PatchVertex], triangles: &[[u32; 3]]) {
        if triangles.is_empty() {
            return;
        }
        let first = self.triangles.len();
        self.parts.push(Part { id, triangles: first..first + triangles.len() });
        let mut known = vec![u32::MAX; vertices.len()];
        for triangle in triangles {
            let welded = triangle.map(|v| {
                let number = &mut known[v as usize];
                if *number == u32::MAX {
                    *number = self.number(id.level, IVec3::from_array(vertices[v as usize].position));
                }
                *number
            });
            self.triangles.push(welded);
        }
    }

    fn number(&mut self, level: u8, position: IVec3) -> u32 {
        let next = self.positions.len() as u32;
        let number = *self.numbers.entry(position).or_insert(next);
        if number == next {
            self.positions.push(position);
            self.levels.push(level);
        }
        let finest = &mut self.levels[number as usize];
        *finest = level.max(*finest);
        number
    }

    /// Directed edges that no opposite edge cancels: 0 for a closed surface.
    pub fn open_edges(&self) -> usize {
        rim(&self.triangles).len()
    }
}

/// The surface that a view draws of all stored patches without geomorphs, so that every vertex is on the lattice; `load` reads one. `whole` draws what is out of sight too, which makes
/// one closed surface around the planet.
///
/// # Errors
/// Those of `load`.
pub fn view_surface<E>(
    tree: &PatchTree,
    view: &View,
    whole: bool,
    mut load: impl FnMut(PatchId) -> Result<LoadedPatch, E>,
) -> Result<Welded, E> {
    let view = if whole { view.without_culling() } else { *view }.without_geomorphs();
    let mut surface = Welded::default();
    for leaf in cut(tree, &view, &|_| true).leaves {
        if whole || tree.get(leaf.id).is_some_and(|node| is_visible(tree, &view, &node.space)) {
            let patch = load(leaf.id)?;
            surface.add(leaf.id, &patch.vertices, &drawn(&view, &leaf, &patch));
        }
    }
    Ok(surface)
}

/// The triangles that a view draws of a patch.
fn drawn(view: &View, leaf: &Leaf, patch: &LoadedPatch) -> Vec<[u32; 3]> {
    let work = patch.reach.work(view);
    let vertices = &patch.vertices[..work.vertices as usize];
    let selected = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
    let resolved = resolve(vertices, &selected.awake);
    emit(&view.gpu, &patch.triangles(&work), &resolved, &selected.drawn_positions)
}
