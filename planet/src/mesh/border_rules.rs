//! The given part of a patch's hierarchy: kinds, wakes and targets of the vertices on its four sides.
//!
//! docs/design.md: "Borders" (canonical wakes, builder rules 1 and 2) and "Mixed levels".

use super::border::{targets, BorderLine};
use super::wake::Wake;
use crate::globe::patch::Side;
use crate::ground::{Ground, HeightGrid};
use terrane_heightfield::decimate::mesh::NONE;

/// What may happen to a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Collapses into any neighbour.
    Interior,
    /// Collapses along its side into its target.
    Border,
    /// Never collapses: corners, mid-edge vertices without a coarser neighbour, and what became their ring.
    Fixed,
}

/// Rules of all vertices of a patch, by vertex number.
pub struct BorderRules {
    /// Kind of every vertex.
    pub kind: Vec<Kind>,
    /// Sides a vertex lies on, as bits of [`Side::bit`].
    pub sides: Vec<u8>,
    /// Wake next to a neighbour of the same or a finer level.
    pub wake: Vec<Wake>,
    /// Wake next to a coarser neighbour (only sides on the parent's boundary have one).
    pub coarser_wake: Vec<Wake>,
    /// The wake that collapses beside a border vertex must respect.
    pub low: Vec<f64>,
    /// The wake that propagates into interior vertices.
    pub high: Vec<f64>,
    /// Position in the queue of a border vertex.
    pub key: Vec<f64>,
    /// Where a border vertex falls to.
    pub target: Vec<u32>,
    /// Its neighbour on the other side when it falls.
    pub other: Vec<u32>,
    /// Mid-edge vertices that collapse last of all, next to a coarser neighbour only.
    pub last: Vec<bool>,
}

impl BorderRules {
    /// Computes the rules of a sampled patch.
    pub fn new(ground: &Ground, grid: &HeightGrid, kappa: f64) -> BorderRules {
        let n = ground.cells as usize;
        let mut rules = BorderRules::interior(n);
        for side in Side::ALL {
            rules.add_side(ground, grid, side, kappa);
        }
        rules.fix_corners(n);
        rules
    }

    /// Rules of a patch without neighbours: vertices on its sides only stay on them. To compare with, and for single patches.
    pub fn free(cells: u32) -> BorderRules {
        let n = cells as usize;
        let mut rules = BorderRules::interior(n);
        for side in Side::ALL {
            (0..=n).for_each(|k| rules.sides[vertex_on_side(side, k, n)] |= side.bit());
        }
        rules.fix_corners(n);
        rules
    }

    /// A patch whose vertices are all interior.
    fn interior(n: usize) -> BorderRules {
        let count = (n + 1) * (n + 1);
        BorderRules {
            kind: vec![Kind::Interior; count],
            sides: vec![0; count],
            wake: vec![Wake::ASLEEP; count],
            coarser_wake: vec![Wake::ASLEEP; count],
            low: vec![f64::INFINITY; count],
            high: vec![f64::INFINITY; count],
            key: vec![f64::INFINITY; count],
            target: vec![NONE; count],
            other: vec![NONE; count],
            last: vec![false; count],
        }
    }

    fn fix_corners(&mut self, n: usize) {
        for corner in [0, n, n * (n + 1), n * (n + 2)] {
            self.kind[corner] = Kind::Fixed;
            self.wake[corner] = Wake::ALWAYS;
            self.coarser_wake[corner] = Wake::ALWAYS;
        }
    }

    fn add_side(&mut self, ground: &Ground, grid: &HeightGrid, side: Side, kappa: f64) {
        let id = grid.id;
        let n = ground.cells as usize;
        let line = BorderLine::of_side(id, side);
        let keys = line.canonical_wakes(ground, grid, id.level, n, kappa);
        let wakes = line.shared_wakes(ground, grid, id.level, &keys, kappa);
        let coarser = id.parent().filter(|_| id.on_parent_boundary(side)).map(|parent| {
            let line = BorderLine::of_side(parent, side);
            let canonical = line.canonical_wakes(ground, grid, parent.level, n, kappa);
            let wakes = line.shared_wakes(ground, grid, parent.level, &canonical, kappa);
            let half = if side.is_horizontal() { id.x } else { id.y } % 2 * (n as u32 / 2);
            move |k: usize| wakes[half as usize + k / 2]
        });
        let first = line.first_index(ground, id.level);
        let vertex = |k: i64| vertex_on_side(side, k as usize, n);
        for k in 0..=n {
            self.sides[vertex(k as i64)] |= side.bit();
        }
        for k in 1..n {
            let v = vertex(k as i64);
            let (target, other) = targets(first + k as i64);
            self.target[v] = vertex(target - first) as u32;
            self.other[v] = vertex(other - first) as u32;
            self.kind[v] = Kind::Border;
            self.key[v] = keys[k].distance();
            let coarser_wake = match &coarser {
                Some(wake) if k % 2 == 0 => wake(k),
                Some(_) => Wake::ASLEEP,
                None => wakes[k],
            };
            self.set_wakes(v, wakes[k], coarser_wake, k % 2 == 0);
            if k == n / 2 {
                self.set_mid_edge(v, coarser.is_some());
            }
        }
    }

    fn set_wakes(&mut self, v: usize, wake: Wake, coarser_wake: Wake, even: bool) {
        self.wake[v] = wake;
        self.coarser_wake[v] = coarser_wake;
        let given = if even { [wake, coarser_wake] } else { [wake, wake] };
        self.low[v] = given[0].min(given[1]).distance();
        self.high[v] = given[0].max(given[1]).distance();
    }

    /// Mid-edge vertices stay awake, so that a finer neighbour needs no flag; only a coarser one puts them to sleep.
    fn set_mid_edge(&mut self, v: usize, has_coarser: bool) {
        self.wake[v] = Wake::ALWAYS;
        if has_coarser {
            self.low[v] = self.coarser_wake[v].distance();
            self.key[v] = f64::MAX;
            self.last[v] = true;
        } else {
            self.coarser_wake[v] = Wake::ALWAYS;
            self.kind[v] = Kind::Fixed;
            self.low[v] = f64::INFINITY;
            self.high[v] = f64::INFINITY;
        }
    }
}

/// Vertex number of sample `k` along a side.
pub fn vertex_on_side(side: Side, k: usize, cells: usize) -> usize {
    let row = cells + 1;
    match side {
        Side::Left => k * row,
        Side::Right => k * row + cells,
        Side::Bottom => k,
        Side::Top => cells * row + k,
    }
}
