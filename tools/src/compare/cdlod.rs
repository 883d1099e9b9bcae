//! A quadtree of regular grids with morphing: CDLOD (Strugar 2009), and the same with ranges from stored errors as in chunked LOD
//! (Ulrich 2002).
//!
//! Every node of a quadtree over each face is a grid of the same number of cells. A node is refined where the viewer is nearer to
//! its box than its range; of a child that is not, the node's own quarter is drawn. Towards the end of its parent's range a node's odd
//! vertices slide onto even ones, so that it becomes its parent's grid.
//!
//! In their favour: neighbours need not match (no cracks are looked for); a node's box holds its own samples and error, no more;
//! triangles that have slid together do not count; diagonals alternate as in the finest surface, so that the finest nodes are exact.

use super::setting::{pixels, Plane, Setting};
use super::sheet::Sheet;
use super::Method;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;
use terrane_heightfield::decimate::mesh::grid_triangles;
use terrane_planet::draw::cut::is_visible;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::lattice::LatticeBox;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::store::StoreError;

/// Share of a range at its far end in which vertices slide (a third of the zone from the next finer range to this one, as in the
/// paper).
const MORPH_ZONE: f64 = 1.0 / 6.0;

/// Range in node sizes, times the knob in pixels.
const SIZES: f64 = 16.0;

/// Fewest cells along a node's side: its quarters' sides are even then, so that diagonals alternate across all of them.
pub(crate) const LEAST_CELLS: u32 = 4;

/// What decides the ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ranges {
    /// The node's size (Strugar).
    Size,
    /// The node's error (Ulrich).
    Error,
}

/// The quadtrees, as grids of one number of cells.
pub(crate) struct Cdlod {
    cells: u32,
    ranges: Ranges,
    nodes: Arc<HashMap<PatchId, Node>>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LatticeBox,
    /// Radial distance of the finest samples from the node's grid in lattice units, at most; 0 without finer samples.
    error: f64,
    /// The part of it that the patch which it was measured in does not know.
    beyond: f64,
}

/// Samples of a node: which patch has them, the first one, and the step between them.
#[derive(Clone, Copy, Debug)]
struct Samples {
    patch: PatchId,
    first: [u32; 2],
    step: u32,
}

impl Cdlod {
    /// The quadtrees over the stored patches, with both kinds of ranges. `cells` is at least [`LEAST_CELLS`] and
    /// divides half a patch's cells.
    pub(crate) fn family(setting: &Setting, cells: u32) -> Result<Vec<Cdlod>, StoreError> {
        let nodes = Arc::new(nodes(setting, cells)?);
        Ok([Ranges::Error, Ranges::Size].map(|ranges| Cdlod { cells, ranges, nodes: nodes.clone() }).into())
    }

    fn samples(&self, patch_cells: u32, id: PatchId) -> Samples {
        samples_of(id, patch_cells / self.cells, self.cells)
    }

    /// Distance within which a node is refined.
    fn range(&self, setting: &Setting, id: PatchId, knob: f64, camera: &Camera) -> f64 {
        match self.ranges {
            Ranges::Size => {
                std::f64::consts::FRAC_PI_2 * setting.tree.lattice.radius / f64::from(1u32 << id.level) * SIZES / knob
            }
            Ranges::Error => pixels(self.nodes[&id].error, knob, camera),
        }
    }
}

impl Method for Cdlod {
    fn family(&self) -> &'static str {
        "CDLOD"
    }

    fn variant(&self) -> String {
        let ranges = match self.ranges {
            Ranges::Size => "size",
            Ranges::Error => "error",
        };
        format!("{}², ranges by {ranges}", self.cells)
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let view = setting.view(camera, knob);
        let mut walk = Walk { tree: self, setting, view: &view, knob, sheet };
        PatchId::roots().try_for_each(|root| walk.node(root, f64::INFINITY))
    }
}

struct Walk<'a, 'b, 's> {
    tree: &'a Cdlod,
    setting: &'a Setting,
    view: &'a View,
    knob: f64,
    sheet: &'b mut Sheet<'s>,
}

impl Walk<'_, '_, '_> {
    /// Draws a node, or what refines it; vertices slide towards `parent_range`.
    fn node(&mut self, id: PatchId, parent_range: f64) -> Result<(), StoreError> {
        if self.is_hidden(id) {
            return Ok(());
        }
        let range = self.tree.range(self.setting, id, self.knob, &self.view.camera);
        let Some(children) = children(&self.tree.nodes, id).filter(|_| self.distance(id) < range) else {
            return self.draw(id, [0, 0], self.tree.cells, parent_range);
        };
        for (k, child) in children.into_iter().enumerate() {
            if self.distance(child) < range {
                self.node(child, range)?;
            } else if !self.is_hidden(child) {
                let half = self.tree.cells / 2;
                self.draw(id, [k as u32 % 2 * half, k as u32 / 2 * half], half, parent_range)?;
            }
        }
        Ok(())
    }

    /// The node's box and, around it, its error.
    fn bounds(&self, id: PatchId) -> (DVec3, DVec3) {
        let Node { bounds, error, .. } = self.tree.nodes[&id];
        (bounds.low.as_dvec3() - error, bounds.high.as_dvec3() + error)
    }

    fn distance(&self, id: PatchId) -> f64 {
        let (low, high) = self.bounds(id);
        self.view.eye.distance(self.view.eye.clamp(low, high))
    }

    fn is_hidden(&self, id: PatchId) -> bool {
        let (low, high) = self.bounds(id);
        let (low, high) = (low - self.view.eye, high - self.view.eye);
        if self.view.planes.iter().any(|&n| (low * n).min(high * n).element_sum() > 0.0) {
            return true;
        }
        let tree = &self.setting.tree;
        tree.get(self.tree.samples(tree.cells, id).patch).is_some_and(|node| !is_visible(tree, self.view, &node.space))
    }

    /// Draws a square of a node's cells.
    fn draw(&mut self, id: PatchId, first: [u32; 2], cells: u32, parent_range: f64) -> Result<(), StoreError> {
        let row = self.setting.tree.cells + 1;
        let samples = self.tree.samples(self.setting.tree.cells, id);
        let positions = self.setting.positions(samples.patch)?;
        let at = |i: u32, j: u32| {
            let [i, j] = [samples.first[0] + i * samples.step, samples.first[1] + j * samples.step];
            positions[(j * row + i) as usize].as_dvec3()
        };
        let zone = MORPH_ZONE * parent_range;
        let weight = |p: DVec3| ((p.distance(self.view.eye) - (parent_range - zone)) / zone).clamp(0.0, 1.0);
        let mut drawn = Vec::with_capacity((cells as usize + 1).pow(2));
        for (i, j) in (0..=cells).flat_map(|j| (0..=cells).map(move |i| (first[0] + i, first[1] + j))) {
            let own = at(i, j);
            // A root has no parent to become.
            let slid = if parent_range.is_finite() { weight(own) } else { 0.0 };
            let (pi, pj) = morph_target(i, j);
            drawn.push(if slid > 0.0 { own.lerp(at(pi, pj), slid) } else { own });
        }
        let mut triangles = grid_triangles(cells);
        triangles.retain(|t| {
            let [a, b, c] = t.map(|v| drawn[v as usize]);
            a != b && b != c && c != a
        });
        self.sheet.add(id.face, drawn.len(), |v| drawn[v as usize], &triangles);
        Ok(())
    }
}

/// All nodes that the stored patches have samples of.
fn nodes(setting: &Setting, cells: u32) -> Result<HashMap<PatchId, Node>, StoreError> {
    let mut ids: Vec<PatchId> = setting.tree.ids().collect();
    ids.sort_unstable();
    let found: Vec<Vec<(PatchId, LatticeBox, f64)>> =
        ids.par_iter().map(|&id| nodes_in(setting, id, cells)).collect::<Result<_, _>>()?;
    let mut nodes = HashMap::new();
    for (id, bounds, error) in found.into_iter().flatten() {
        let node = nodes.entry(id).or_insert(Node { bounds: LatticeBox::EMPTY, error: 0.0, beyond: 0.0 });
        node.bounds = node.bounds.union(bounds);
        node.error = node.error.max(error);
    }
    let mut finest_first: Vec<PatchId> = nodes.keys().copied().collect();
    finest_first.sort_unstable_by_key(|id| std::cmp::Reverse(id.level));
    // From this level on a node's error was measured at the next finer samples alone; before, at all of a face's patch.
    let below_a_patch = (setting.tree.cells / cells).ilog2() as u8;
    for id in finest_first {
        let beyond = |child: &PatchId| {
            let node = &nodes[child];
            if child.level >= below_a_patch {
                node.error
            } else {
                node.beyond
            }
        };
        let below = children(&nodes, id).map_or(0.0, |children| children.iter().map(beyond).fold(0.0, f64::max));
        if let Some(node) = nodes.get_mut(&id) {
            node.error += below;
            node.beyond = below;
        }
    }
    Ok(nodes)
}

/// The four children of a node, if their samples are stored.
fn children(nodes: &HashMap<PatchId, Node>, id: PatchId) -> Option<[PatchId; 4]> {
    id.children().filter(|children| children.iter().all(|child| nodes.contains_key(child)))
}

/// Which samples a node has; `nodes` of them lie along a patch's side where nodes are smaller than patches. Coarser nodes than a
/// whole face's patch skip samples of it.
fn samples_of(id: PatchId, nodes: u32, cells: u32) -> Samples {
    let deeper = nodes.ilog2() as u8;
    let level = id.level.saturating_sub(deeper);
    let step = 1 << deeper.saturating_sub(id.level);
    // Nodes along a side of the patch.
    let across = nodes.min(1 << id.level);
    let patch = PatchId { level, x: id.x / across, y: id.y / across, ..id };
    Samples { patch, first: [id.x, id.y].map(|k| k % across * cells * step), step }
}

/// Nodes about which a patch knows something: the box of those that have their samples from it, the error of those that are
/// refined with it.
fn nodes_in(setting: &Setting, patch: PatchId, cells: u32) -> Result<Vec<(PatchId, LatticeBox, f64)>, StoreError> {
    let all = setting.tree.cells;
    let (row, nodes) = (all + 1, all / cells);
    let deeper = nodes.ilog2() as u8;
    let positions = setting.positions(patch)?;
    let plane = Plane::new(patch, all, &positions);
    let mut found = Vec::new();
    // Along the patch's side: `across` nodes with a sample every `step`.
    let mut visit = |level: u8, across: u32, step: u32, own: bool| {
        for (x, y) in (0..across).flat_map(|y| (0..across).map(move |x| (x, y))) {
            let id = PatchId { level, x: patch.x * across + x, y: patch.y * across + y, ..patch };
            let first = [x * cells * step, y * cells * step];
            let number = |v: u32| (first[1] + v / (cells + 1) * step) * row + first[0] + v % (cells + 1) * step;
            let mut bounds = LatticeBox::EMPTY;
            if own {
                (0..(cells + 1).pow(2)).for_each(|v| bounds.include(positions[number(v) as usize]));
            }
            let error = if step > 1 {
                grid_triangles(cells).into_iter().map(|t| plane.deviation(t.map(number))).fold(0.0, f64::max)
            } else {
                0.0
            };
            found.push((id, bounds, error));
        }
    };
    visit(patch.level + deeper, nodes, 1, true);
    if patch.level > 0 {
        visit(patch.level + deeper - 1, nodes / 2, 2, false);
    } else {
        (0..deeper).for_each(|level| visit(level, 1 << level, nodes >> level, true));
    }
    Ok(found)
}

/// The even sample that a sample of a grid slides onto. That of a cell's middle lies on the diagonal of the parent's grid.
fn morph_target(i: u32, j: u32) -> (u32, u32) {
    let falling = (i / 2 + j / 2) % 2 == 1;
    match (i % 2, j % 2) {
        (1, 1) if falling => (i + 1, j - 1),
        (odd, above) => (i - odd, j - above),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_that_has_slid_all_the_way_is_its_parents() {
        let (fine, coarse) = (8, 4);
        let target = |v: u32| {
            let (i, j) = morph_target(v % (fine + 1), v / (fine + 1));
            assert!(i % 2 == 0 && j % 2 == 0);
            j / 2 * (coarse + 1) + i / 2
        };
        let slid = grid_triangles(fine).into_iter().map(|t| t.map(target));
        let mut left: Vec<[u32; 3]> = slid.filter(|[a, b, c]| a != b && b != c && c != a).map(first_smallest).collect();
        let mut parent: Vec<[u32; 3]> = grid_triangles(coarse).into_iter().map(first_smallest).collect();
        left.sort_unstable();
        parent.sort_unstable();
        assert_eq!(left, parent);
    }

    fn first_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
        match a.min(b).min(c) {
            least if least == a => [a, b, c],
            least if least == b => [b, c, a],
            _ => [c, a, b],
        }
    }

    #[test]
    fn children_share_their_parents_samples() {
        let (nodes, cells) = (4, 8);
        let point = |id: PatchId, i: u32| {
            let Samples { patch, first, step } = samples_of(id, nodes, cells);
            patch.point((first[0] + i * step) as i32, (first[1] + i * step) as i32, nodes * cells)
        };
        for (level, x, y) in [(0, 0, 0), (1, 1, 0), (2, 3, 1), (3, 5, 2)] {
            let id = PatchId::new(PatchId::roots().next().unwrap().face, level, x, y).unwrap();
            let [first, .., last] = id.children().unwrap();
            assert_eq!((point(id, 0), point(id, 4)), (point(first, 0), point(first, 8)));
            assert_eq!((point(id, 6), point(id, 8)), (point(last, 4), point(last, 8)));
        }
    }
}
