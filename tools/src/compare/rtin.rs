//! Right-triangulated irregular networks (Evans, Kirkpatrick and Townsend 2001), one a patch: longest-edge bisection of the full grid.
//!
//! A vertex is the middle of the longest edges of two triangles; it is drawn where one of them, drawn whole, would be off by more than
//! the knob in pixels, or where a finer vertex needs it. Each triangle's error is the true one, at all samples under it. What the
//! finer vertices need is found anew in every view, from the finest to the coarsest: fewer vertices than with errors and balls
//! saturated beforehand (Lindstrom and Pascucci 2001), which is what a run time would do.
//!
//! In their favour: patches need not match along their borders, and nothing is drawn finer out of the frustum.

use super::setting::{outside, pixels, CutRule, PatchCache, Plane, Setting};
use super::sheet::Sheet;
use super::Method;
use glam::{DVec3, IVec3};
use std::sync::Arc;
use terrane_planet::draw::cut::Leaf;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::certificate::DEVIATION_SHARE;
use terrane_planet::store::StoreError;

/// No vertex.
const NONE: u16 = u16::MAX;

/// One triangle that can be bisected.
#[derive(Clone, Copy, Debug)]
struct Bisection {
    /// Corners, the right angle last, counter-clockwise.
    corners: [u16; 3],
    /// Middle of the longest edge.
    middle: u16,
    /// Middles of the longest edges of its halves; [`NONE`] if they cannot be bisected.
    finer: [u16; 2],
}

/// All triangles of the bisection hierarchy of a grid, coarse before fine.
pub(crate) struct Hierarchy {
    bisections: Vec<Bisection>,
    roots: [[u16; 3]; 2],
}

/// What is known of the vertices of a patch.
struct PatchErrors {
    /// Radial error in lattice units of the triangles that a vertex bisects.
    error: Vec<f32>,
    /// Distance in lattice units from the vertex within which they lie.
    extent: Vec<f32>,
}

/// RTIN over the patches of a cut.
pub(crate) struct Rtin {
    hierarchy: Hierarchy,
    rule: CutRule,
    /// Tolerance of the cut over the knob.
    cut: f64,
    patches: Arc<PatchCache<PatchErrors>>,
}

impl Hierarchy {
    /// The hierarchy of a grid of `cells` cells a side, a power of two.
    pub(crate) fn new(cells: u32) -> Hierarchy {
        let corner = |i: u32, j: u32| (j * (cells + 1) + i) as u16;
        let [a, b, c, d] = [corner(0, 0), corner(cells, 0), corner(0, cells), corner(cells, cells)];
        let mut hierarchy = Hierarchy { bisections: Vec::new(), roots: [[d, a, b], [a, d, c]] };
        let mut level = hierarchy.roots.to_vec();
        while !level.is_empty() {
            let mut halves = Vec::with_capacity(2 * level.len());
            for [a, b, c] in level {
                if let Some(middle) = middle(cells, a, b) {
                    let (left, right) = ([c, a, middle], [b, c, middle]);
                    let finer = [left, right].map(|[a, b, _]| self::middle(cells, a, b).unwrap_or(NONE));
                    hierarchy.bisections.push(Bisection { corners: [a, b, c], middle, finer });
                    halves.extend([left, right]);
                }
            }
            level = halves;
        }
        hierarchy
    }

    /// Adds to a set of vertices whatever those in it need.
    fn close(&self, drawn: &mut [bool]) {
        for bisection in self.bisections.iter().rev() {
            let needed = bisection.finer.iter().any(|&v| v != NONE && drawn[usize::from(v)]);
            drawn[usize::from(bisection.middle)] |= needed;
        }
    }

    /// The triangles of a closed set of vertices.
    fn triangles(&self, cells: u32, drawn: &[bool]) -> Vec<[u32; 3]> {
        let mut waiting = self.roots.to_vec();
        let mut triangles = Vec::new();
        while let Some([a, b, c]) = waiting.pop() {
            match middle(cells, a, b).filter(|&m| drawn[usize::from(m)]) {
                Some(m) => waiting.extend([[c, a, m], [b, c, m]]),
                None => triangles.push([a, b, c].map(u32::from)),
            }
        }
        triangles
    }
}

/// The vertex halfway between two; `None` if there is none.
fn middle(cells: u32, a: u16, b: u16) -> Option<u16> {
    let row = cells as u16 + 1;
    let (i, j) = (a % row + b % row, a / row + b / row);
    (i % 2 == 0 && j % 2 == 0).then_some(j / 2 * row + i / 2)
}

impl PatchErrors {
    fn new(hierarchy: &Hierarchy, id: PatchId, cells: u32, positions: &[IVec3]) -> PatchErrors {
        let plane = Plane::new(id, cells, positions);
        let count = positions.len();
        let mut errors = PatchErrors { error: vec![0.0; count], extent: vec![0.0; count] };
        for Bisection { corners, middle, .. } in &hierarchy.bisections {
            let v = usize::from(*middle);
            errors.error[v] = errors.error[v].max(plane.deviation(corners.map(u32::from)) as f32);
            let position = |v: u16| positions[usize::from(v)].as_dvec3();
            let extent = corners.map(|c| position(c).distance(position(*middle))).into_iter().fold(0.0, f64::max);
            errors.extent[v] = errors.extent[v].max(extent as f32);
        }
        errors
    }

    /// Whether the triangles that a vertex bisects are in view and off by more than `most` pixels.
    fn is_needed(&self, view: &View, v: usize, position: DVec3, most: f64) -> bool {
        let (error, extent) = (f64::from(self.error[v]), f64::from(self.extent[v]));
        pixels(error, position.distance(view.eye) - extent, &view.camera) > most && !outside(view, position, extent)
    }
}

impl Rtin {
    /// RTIN over the patches that a rule asks for with `cut` times the knob as tolerance.
    pub(crate) fn family(setting: &Setting, variants: &[(CutRule, f64)]) -> Vec<Rtin> {
        let patches = Arc::new(PatchCache::new());
        let of = |&(rule, cut)| Rtin { hierarchy: Hierarchy::new(setting.tree.cells), rule, cut, patches: patches.clone() };
        variants.iter().map(of).collect()
    }

    fn draw_patch(&self, setting: &Setting, view: &View, leaf: &Leaf, most: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let cells = setting.tree.cells;
        let positions = setting.positions(leaf.id)?;
        let errors = self.patches.get(leaf.id, || Ok(PatchErrors::new(&self.hierarchy, leaf.id, cells, &positions)))?;
        let position = |p: &IVec3| p.as_dvec3();
        let mut drawn: Vec<bool> =
            positions.iter().enumerate().map(|(v, p)| errors.is_needed(view, v, position(p), most)).collect();
        self.hierarchy.close(&mut drawn);
        let triangles = self.hierarchy.triangles(cells, &drawn);
        sheet.add(leaf.id.face, drawn.len(), |v| position(&positions[v as usize]), &triangles);
        Ok(())
    }
}

impl Method for Rtin {
    fn family(&self) -> &'static str {
        "RTIN"
    }

    fn variant(&self) -> String {
        self.rule.describe(self.cut)
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let view = setting.view(camera, self.cut * knob);
        let leaves = setting.visible_leaves(&view, self.rule);
        leaves.iter().try_for_each(|leaf| self.draw_patch(setting, &view, leaf, (1.0 - DEVIATION_SHARE) * knob, sheet))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{doubled_area, open_edges_inside};
    use super::*;
    use terrane_planet::globe::random::Random;

    const CELLS: u32 = 16;

    fn random_vertices(hierarchy: &Hierarchy, seed: u64) -> Vec<bool> {
        let mut random = Random::new(seed);
        let mut drawn = vec![false; 17 * 17];
        for bisection in &hierarchy.bisections {
            drawn[usize::from(bisection.middle)] |= !random.bits().is_multiple_of(4);
        }
        drawn
    }

    #[test]
    fn closed_sets_have_no_cracks_and_open_ones_do() {
        let hierarchy = Hierarchy::new(CELLS);
        let mut cracked = 0;
        for seed in 0..32 {
            let mut drawn = random_vertices(&hierarchy, seed);
            cracked += usize::from(open_edges_inside(CELLS, &hierarchy.triangles(CELLS, &drawn)) > 0);
            hierarchy.close(&mut drawn);
            let triangles = hierarchy.triangles(CELLS, &drawn);
            assert_eq!(open_edges_inside(CELLS, &triangles), 0, "seed {seed}");
            assert_eq!(doubled_area(CELLS, &triangles), 2 * 16 * 16, "seed {seed}");
        }
        assert!(cracked > 16, "only {cracked} sets needed closing");
    }

    #[test]
    fn all_vertices_together_are_the_full_grid() {
        let hierarchy = Hierarchy::new(CELLS);
        let sorted = |mut triangles: Vec<[u32; 3]>| {
            triangles.iter_mut().for_each(|t| t.sort_unstable());
            triangles.sort_unstable();
            triangles
        };
        let all = hierarchy.triangles(CELLS, &[true; 17 * 17]);
        assert_eq!(sorted(all), sorted(terrane_heightfield::decimate::mesh::grid_triangles(CELLS)));
        assert_eq!(hierarchy.triangles(CELLS, &[false; 17 * 17]).len(), 2);
    }
}
