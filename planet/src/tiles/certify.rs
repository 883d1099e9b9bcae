//! What is promised of tiles: how far each lies off the finest surface, and how deep its skirts must be.
//!
//! In: what was measured of every patch. Out: errors that never rise from a tile to its children, depths, and steps. docs/tiles.md has
//! the formulas, docs/design.md ("3D Tiles") why they hold.

use crate::globe::patch::{PatchId, Side};
use crate::mesh::wake::Wake;
use glam::DVec3;
use std::collections::HashMap;

/// What was measured of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    /// Largest radial distance in metres of the next level's samples from the full grid, a quarter each.
    pub(super) quarters: [f64; 4],
    /// Radial distance in metres of the drawn ground from the full grid, rounding included.
    pub(super) ground: f64,
    /// Radial distance in metres of the drawn sea from its sphere, rounding included; 0 without sea.
    pub(super) sea: f64,
    /// Metres a step, of ground and sea.
    pub(super) steps: [f64; 2],
    /// Corners of the boxes of ground and sea, in metres from the planet's centre; those of the ground again without sea.
    pub(super) bounds: [[DVec3; 2]; 2],
    /// The largest wake that sleeps.
    pub(super) asleep: Wake,
}

/// What is promised of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Largest radial distance in metres from the finest surface: the ground of the finest tiles, or the sea.
    pub error: f64,
    /// Depth of the skirts in metres, in the order of [`Side::ALL`].
    pub skirts: [f64; 4],
}

/// How far outside of the tile the feet of its skirts stand, over its error: half a pixel where the error is one. Devices move corners to a
/// grid of a sixteenth to a 256th of a pixel, and borders of different triangles would show gaps so wide.
const FLARE_SHARE: f64 = 0.5;

impl Promise {
    /// How far outside of the tile the feet of its skirts stand, in metres.
    pub fn flare(&self) -> f64 {
        FLARE_SHARE * self.error
    }

    /// How far from the tile skirts reach in any direction, in metres.
    pub(super) fn reach(&self) -> f64 {
        self.skirts.into_iter().fold(0.0, f64::max) + 2.0 * self.flare()
    }
}

/// Promises of all patches.
pub(super) fn promises(measured: &HashMap<PatchId, Measured>) -> HashMap<PatchId, Promise> {
    let mut order: Vec<PatchId> = measured.keys().copied().collect();
    order.sort_by_key(|id| std::cmp::Reverse(id.level));
    let (mut below, mut errors) = (HashMap::new(), HashMap::new());
    for id in order {
        let of = &measured[&id];
        let (mut finer, mut error) = (0.0_f64, of.sea);
        for (k, child) in children(measured, id).into_iter().flatten().enumerate() {
            finer = finer.max(of.quarters[k] + below[&child]);
            error = error.max(errors[&child]);
        }
        below.insert(id, finer);
        errors.insert(id, error.max(finer + of.ground));
    }
    let surfaces = Surfaces { measured, below, errors };
    let promise =
        |&id: &PatchId| (id, Promise { error: surfaces.errors[&id], skirts: Side::ALL.map(|side| surfaces.depth(id, side)) });
    measured.keys().map(promise).collect()
}

/// The children of a patch, if it has some.
fn children(measured: &HashMap<PatchId, Measured>, id: PatchId) -> Option<[PatchId; 4]> {
    id.children().filter(|children| measured.contains_key(&children[0]))
}

struct Surfaces<'a> {
    measured: &'a HashMap<PatchId, Measured>,
    /// How far the finest surface below a patch lies off its full grid.
    below: HashMap<PatchId, f64>,
    errors: HashMap<PatchId, f64>,
}

impl Surfaces<'_> {
    /// How deep a tile's skirt must be on a side: both surfaces that may meet there lie within their errors of the finest one on their
    /// side of the border, and these two within what one has and the other has not.
    fn depth(&self, id: PatchId, side: Side) -> f64 {
        let mut widest = id;
        while widest.on_parent_boundary(side) {
            let Some(parent) = widest.parent() else { break };
            widest = parent;
        }
        // The coarsest tile that can stand across has the largest error of all that can.
        let across = self.errors.get(&widest.neighbour(side)).copied().unwrap_or(0.0);
        let mut level = id;
        while !self.measured.contains_key(&level.neighbour(side)) {
            let Some(parent) = level.parent() else { break };
            level = parent;
        }
        // Rounding moves each end of a wall by up to two steps.
        let steps = self.measured[&id].steps.into_iter().fold(0.0, f64::max);
        rounded_up(self.errors[&id] + across + self.mismatch(level, side) + 4.0 * steps)
    }

    /// How far the finest surfaces on both sides of a border lie apart: one may have levels there that the other has not.
    fn mismatch(&self, id: PatchId, side: Side) -> f64 {
        let across = id.neighbour(side);
        match (children(self.measured, id), children(self.measured, across)) {
            (None, None) => 0.0,
            (Some(_), None) => self.below[&id],
            (None, Some(_)) => self.below[&across],
            (Some(children), Some(_)) => {
                let on_side = children.into_iter().filter(|child| child.on_parent_boundary(side));
                on_side.map(|child| self.mismatch(child, side)).fold(0.0, f64::max)
            }
        }
    }
}

/// A depth with three bits after its first, rounded up: a small change of one tile then changes few of its neighbours.
fn rounded_up(depth: f64) -> f64 {
    const DROPPED: u32 = f64::MANTISSA_DIGITS - 1 - 3;
    f64::from_bits((depth.to_bits() + (1 << DROPPED) - 1) >> DROPPED << DROPPED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::Face;
    use crate::planet::bake::BakePlan;

    fn halving(id: PatchId) -> Measured {
        let deviation = 64.0 / f64::from(1 << id.level);
        Measured {
            quarters: [deviation; 4],
            ground: deviation / 4.0,
            sea: 0.0,
            steps: [0.0; 2],
            bounds: [[DVec3::ZERO; 2]; 2],
            asleep: Wake::ASLEEP,
        }
    }

    #[test]
    fn depths_are_rounded_up_by_at_most_an_eighth() {
        for depth in [1e-9, 0.3, 1.0, 8.01, 1023.0, 12_345.678] {
            assert!((depth..depth * 1.125).contains(&rounded_up(depth)), "{depth}: {}", rounded_up(depth));
        }
        assert_eq!([rounded_up(0.0), rounded_up(9.0), rounded_up(9.01)], [0.0, 9.0, 10.0]);
    }

    #[test]
    fn errors_are_sums_over_finer_levels_and_never_rise() {
        let plan = BakePlan::new(1e6, 2, None).unwrap();
        let measured: HashMap<_, _> = plan.patches.iter().map(|&id| (id, halving(id))).collect();
        let promises = promises(&measured);
        let root = PatchId::roots().next().unwrap();
        assert_eq!(promises[&root].error, 64.0 + 32.0 + 16.0);
        let child = root.children().unwrap()[0];
        assert_eq!(promises[&child].error, 32.0 + 8.0);
        assert_eq!(promises[&child.children().unwrap()[3]].error, 4.0);
        for (id, promise) in &promises {
            assert!(id.parent().is_none_or(|parent| promises[&parent].error >= promise.error));
        }
    }

    #[test]
    fn a_coarse_neighbour_counts_only_across_its_own_border() {
        let plan = BakePlan::new(1e6, 2, None).unwrap();
        let measured: HashMap<_, _> = plan.patches.iter().map(|&id| (id, halving(id))).collect();
        let promises = promises(&measured);
        let id = PatchId::new(Face::ALL[0], 2, 1, 0).unwrap();
        // Left a sibling, right a tile of another parent, below another face.
        let [left, right, bottom, top] = promises[&id].skirts;
        assert_eq!([left, right, bottom, top], [4.0 + 4.0, 4.0 + 40.0, 4.0 + 112.0, 4.0 + 4.0].map(rounded_up));
    }

    #[test]
    fn where_one_side_ends_earlier_what_it_lacks_counts() {
        let roots: Vec<PatchId> = PatchId::roots().collect();
        let mut measured: HashMap<_, _> = roots.iter().map(|&id| (id, halving(id))).collect();
        measured.extend(roots[0].children().unwrap().map(|id| (id, halving(id))));
        let promises = promises(&measured);
        let coarse = roots[0].neighbour(Side::Left);
        let side = Side::ALL.into_iter().find(|&side| coarse.neighbour(side) == roots[0]).unwrap();
        assert_eq!(promises[&coarse].skirts[side as usize], rounded_up(16.0 + (64.0 + 16.0) + 64.0));
    }
}
