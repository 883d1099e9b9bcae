//! The CPU's side of the comparison: a patch through `select`, `resolve` and `emit`, and what the GPU made of it beside that.

use super::report::Mismatches;
use crate::headless::Selection;
use std::cmp::Ordering;
use terrane_planet::draw::cut::Leaf;
use terrane_planet::draw::layout::{DrawnVertex, FrameView, PatchDraw, PatchVertex, VERTEX_BITS};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::verify::Rings;

/// A patch as the CPU has it.
pub(super) struct KnownPatch {
    pub(super) loaded: LoadedPatch,
    /// `None` if the hierarchy does not replay, which is a fault.
    pub(super) rings: Option<Rings>,
}

impl KnownPatch {
    pub(super) fn new(mesh: PatchMesh, lattice: &Lattice) -> KnownPatch {
        let rings = Rings::new(&mesh);
        KnownPatch { loaded: LoadedPatch::new(mesh, lattice), rings }
    }
}

/// A drawn patch and what the CPU's stages make of it. Selection and resolution are the same with culling and without.
pub(super) struct Twin<'a> {
    pub(super) known: &'a KnownPatch,
    pub(super) leaf: Leaf,
    gpu: FrameView,
    triangles: Vec<[u16; 3]>,
    vertices: &'a [PatchVertex],
    selected: Selected,
    resolved: Vec<u32>,
}

impl<'a> Twin<'a> {
    pub(super) fn new(view: &View, leaf: &Leaf, known: &'a KnownPatch) -> Twin<'a> {
        let patch = &known.loaded;
        let work = patch.reach.work(view);
        let vertices = &patch.vertices[..work.vertices as usize];
        let selected = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
        let resolved = resolve(vertices, &selected.awake);
        let triangles = patch.triangles(&work);
        Twin { known, leaf: *leaf, gpu: view.without_culling().gpu, triangles, vertices, selected, resolved }
    }

    /// The triangles that `view` draws, or without culling.
    pub(super) fn emit(&self, view: Option<&View>) -> Vec<[u32; 3]> {
        let view = view.map_or(&self.gpu, |view| &view.gpu);
        emit(view, &self.triangles, &self.resolved, &self.selected.drawn_positions)
    }

    /// Where the vertices of the prefix that was selected are drawn.
    pub(super) fn drawn_positions(&self) -> &[DrawnVertex] {
        &self.selected.drawn_positions
    }

    pub(super) fn awake_count(&self) -> usize {
        self.selected.awake.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The GPU's awake bits of this patch.
    pub(super) fn words_of<'s>(&self, draw: &PatchDraw, selection: &'s Selection) -> &'s [u32] {
        let start = draw.awake_offset as usize;
        &selection.awake[start..start + draw.vertex_count.div_ceil(32) as usize]
    }

    /// Where the GPU draws the vertices of this patch.
    pub(super) fn drawn_positions_of<'s>(&self, draw: &PatchDraw, selection: &'s Selection) -> &'s [DrawnVertex] {
        let start = draw.resolve_offset as usize;
        &selection.drawn_positions[start..start + draw.vertex_count as usize]
    }

    /// Differences in table, awake bits, drawn positions and resolved vertices. Patches that were given other tables are not
    /// compared further.
    pub(super) fn compare_stages(&self, draw: &PatchDraw, selection: &Selection) -> Mismatches {
        let tables = (draw.vertex_count, draw.coarser_sides, draw.level);
        if tables != (self.vertices.len() as u32, u32::from(self.leaf.coarser_sides), u32::from(self.leaf.id.level)) {
            return Mismatches { patches: 1, ..Mismatches::default() };
        }
        let start = draw.resolve_offset as usize;
        let resolved = &selection.resolved[start..start + self.vertices.len()];
        let differing_bits = |(a, b): (&u32, &u32)| (a ^ b).count_ones() as usize;
        Mismatches {
            awake: self.words_of(draw, selection).iter().zip(&self.selected.awake).map(differing_bits).sum(),
            drawn_positions: self
                .drawn_positions_of(draw, selection)
                .iter()
                .zip(self.drawn_positions())
                .filter(|(a, b)| a != b)
                .count(),
            resolved: resolved.iter().zip(&self.resolved).filter(|(a, b)| a != b).count(),
            ..Mismatches::default()
        }
    }
}

/// Emitted triangles by patch, and the number of those that name no vertex of any one patch.
pub(crate) fn triangles_by_patch(patches: &[PatchDraw], triangles: &[[u32; 3]]) -> (Vec<Vec<[u32; 3]>>, usize) {
    let mut lists = vec![Vec::new(); patches.len()];
    let mut stray = 0;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| index >> VERTEX_BITS);
        let corners = triangle.map(|index| index & ((1 << VERTEX_BITS) - 1));
        let exists = |draw: &PatchDraw| corners.iter().all(|&v| v < draw.vertex_count);
        if a == b && b == c && patches.get(a as usize).is_some_and(exists) {
            lists[a as usize].push(corners);
        } else {
            stray += 1;
        }
    }
    (lists, stray)
}

/// Triangles that only one of two lists has, in whatever order they are.
pub(super) fn differing_triangles(mut a: Vec<[u32; 3]>, mut b: Vec<[u32; 3]>) -> usize {
    a.sort_unstable();
    b.sort_unstable();
    let (mut i, mut j, mut common) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        match a[i].cmp(&b[j]) {
            Ordering::Less => i += 1,
            Ordering::Greater => j += 1,
            Ordering::Equal => {
                common += 1;
                i += 1;
                j += 1;
            }
        }
    }
    a.len() + b.len() - 2 * common
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differing_triangles_are_counted_with_their_multiplicity() {
        let list = vec![[0, 1, 2], [3, 4, 5], [0, 1, 2]];
        assert_eq!(differing_triangles(list.clone(), vec![[3, 4, 5], [0, 1, 2], [0, 1, 2]]), 0);
        assert_eq!(differing_triangles(list.clone(), vec![[0, 1, 2], [3, 4, 5]]), 1);
        assert_eq!(differing_triangles(list, vec![[0, 2, 1]]), 4);
    }

    #[test]
    fn triangles_of_no_patch_are_stray() {
        let patches = [PatchDraw { vertex_count: 3, ..Default::default() }; 2];
        let second = 1 << VERTEX_BITS;
        let triangles =
            [[0, 1, 2], [second, second + 1, second + 2], [0, 1, second], [0, 1, 3], [2 * second, 2 * second, 2 * second]];
        let (lists, stray) = triangles_by_patch(&patches, &triangles);
        assert_eq!((lists, stray), (vec![vec![[0, 1, 2]], vec![[0, 1, 2]]], 3));
    }
}
