//! The patch cut: which patches a view draws. A pure function of (resident patches, view), 2:1 balanced across edges.
//!
//! A patch splits where the viewer is nearer to its bounds than one of two distances: for closure's sake, seen or not, and for the detail of
//! what is seen of it. And only when all four children are resident, so that missing data makes a coarser picture and never a hole.

use super::tree::{PatchNode, PatchTree};
use super::view::View;
use crate::globe::lattice::LatticeBox;
use crate::globe::patch::{PatchId, Side};
use glam::DVec3;
use std::collections::HashSet;

/// Pixels that a texel may cover before a patch splits for its texture's sake.
pub const TEXEL_PIXELS: f64 = 2.0;

/// Weight of the distance outside the frustum for the sake of what is seen only: detail and textures.
const SEEN_FALLOFF: f64 = 4.0;

/// One drawn patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Which patch.
    pub id: PatchId,
    /// Sides (bits of [`Side::bit`]) across which the drawn neighbour is one level coarser.
    pub coarser_sides: u8,
}

/// The patches that cover the planet in a view.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    /// Drawn patches, in traversal order.
    pub leaves: Vec<Leaf>,
    /// Patches whose children the view wants but which are not all resident, with their urgency (see [`urgency`];
    /// smaller is more urgent).
    pub wanted: Vec<(PatchId, f64)>,
    /// Patches whose children the view wants and which are all resident, but wait for a neighbour to split first.
    pub blocked: Vec<PatchId>,
}

/// Distance in lattice units at which a patch of a level splits for its texture's sake.
pub fn texture_distance(tree: &PatchTree, view: &View, level: u8) -> f64 {
    tree.texel_size(level) / (TEXEL_PIXELS * view.camera.pixel_angle())
}

/// Lower bound of the selection distance (to the eye, plus falloff times distance outside the frustum) over a box.
pub fn distance_to_box(view: &View, bounds: &LatticeBox) -> f64 {
    let (nearest, outside) = nearest_and_outside(view, bounds);
    let oriented = view.orientation.map_or(0.0, |term| term.least(bounds, view.eye));
    nearest.max(oriented) + view.falloff * outside
}

/// Distance from the eye to a box, and how far the whole box lies outside the frustum, at least.
fn nearest_and_outside(view: &View, bounds: &LatticeBox) -> (f64, f64) {
    let (low, high) = (bounds.low.as_dvec3() - view.eye, bounds.high.as_dvec3() - view.eye);
    (DVec3::ZERO.clamp(low, high).length(), outside_by(view, low, high))
}

/// How far the whole box (relative to the eye) lies outside the frustum, at least.
fn outside_by(view: &View, low: DVec3, high: DVec3) -> f64 {
    let least = |n: &DVec3| (low * *n).min(high * *n).element_sum();
    view.planes.iter().map(least).fold(0.0, f64::max)
}

/// Computes the cut. `resident` says which patches can be drawn; the six roots must be.
pub fn cut(tree: &PatchTree, view: &View, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    cut_by(tree, &|id, node| urgency(tree, view, id.level, node), resident)
}

/// The finest surface that the resident patches can be drawn as: every patch splits that can.
pub fn finest_cut(tree: &PatchTree, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    cut_by(tree, &|_, _| 0.0, resident)
}

/// The cut in which the patches split whose urgency is below 1.
pub fn cut_by(tree: &PatchTree, urgency: &dyn Fn(PatchId, &PatchNode) -> f64, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    let mut search = Search {
        tree,
        urgency,
        resident,
        split: HashSet::new(),
        refused: HashSet::new(),
        wanted: Vec::new(),
        blocked: Vec::new(),
    };
    PatchId::roots().for_each(|root| search.refine(root));
    let mut result = Cut { leaves: Vec::new(), wanted: search.wanted, blocked: search.blocked };
    PatchId::roots().for_each(|root| collect(root, &search.split, &mut result.leaves));
    result
}

/// Distance over the distance at which a patch of a level splits, the smaller of the two for closure's sake and for that of what is
/// seen of it: below 1 it splits.
pub fn urgency(tree: &PatchTree, view: &View, level: u8, node: &PatchNode) -> f64 {
    let (nearest, outside) = nearest_and_outside(view, &node.bounds);
    let closure = (nearest + view.falloff * outside) / (view.scale * node.closure_wake);
    let finest_at = (view.scale * node.detail_wake).max(texture_distance(tree, view, level));
    let seen = (nearest + SEEN_FALLOFF * outside) / finest_at;
    if seen < 1.0 && below_horizon(tree, view, node) {
        return closure;
    }
    closure.min(seen)
}

struct Search<'a> {
    tree: &'a PatchTree,
    urgency: &'a dyn Fn(PatchId, &PatchNode) -> f64,
    resident: &'a dyn Fn(PatchId) -> bool,
    split: HashSet<PatchId>,
    refused: HashSet<PatchId>,
    wanted: Vec<(PatchId, f64)>,
    blocked: Vec<PatchId>,
}

impl Search<'_> {
    fn refine(&mut self, id: PatchId) {
        let Some(node) = self.tree.get(id).filter(|_| self.tree.can_split(id)) else { return };
        let urgency = (self.urgency)(id, node);
        if urgency < 1.0 && self.ensure_split(id, urgency) {
            id.children().into_iter().flatten().for_each(|child| self.refine(child));
        }
    }

    /// Splits a patch and whatever coarser neighbours balance asks for; false if some children are not resident.
    fn ensure_split(&mut self, id: PatchId, urgency: f64) -> bool {
        if self.split.contains(&id) {
            return true;
        }
        if self.refused.contains(&id) {
            return false;
        }
        let possible = self.tree.get(id).is_some() && self.tree.can_split(id);
        let ready = possible && id.children().into_iter().flatten().all(self.resident);
        if possible && !ready {
            self.wanted.push((id, urgency));
        }
        // Every neighbour of this level must exist, even if this one cannot split yet: its data is wanted all the same.
        let mut balanced = true;
        for parent in Side::ALL.into_iter().filter_map(|side| id.neighbour(side).parent()) {
            balanced &= self.ensure_split(parent, urgency);
        }
        if ready && balanced {
            self.split.insert(id);
        } else {
            self.refused.insert(id);
            if ready {
                self.blocked.push(id);
            }
        }
        ready && balanced
    }
}

fn collect(id: PatchId, split: &HashSet<PatchId>, leaves: &mut Vec<Leaf>) {
    if split.contains(&id) {
        id.children().into_iter().flatten().for_each(|child| collect(child, split, leaves));
        return;
    }
    let coarser = |side: &Side| id.on_parent_boundary(*side) && id.neighbour(*side).parent().is_some_and(|p| !split.contains(&p));
    let coarser_sides = Side::ALL.iter().filter(|s| coarser(s)).fold(0, |bits, side| bits | side.bit());
    leaves.push(Leaf { id, coarser_sides });
}

/// Whether a drawn patch lies at the rim of the stored data: next to a coarser patch that has no children to split into. There
/// the error is that coarser patch's own, and closure breaks, because vertices that only the finer side has must sleep.
pub fn at_data_rim(tree: &PatchTree, leaf: &Leaf) -> bool {
    sides_beside(leaf, &|coarser| !tree.can_split(coarser)) != 0
}

/// Sides (bits of [`Side::bit`]) across which a drawn patch has a coarser neighbour for which a condition holds.
pub fn sides_beside(leaf: &Leaf, condition: &dyn Fn(PatchId) -> bool) -> u8 {
    let drawn_coarser = Side::ALL.iter().filter(|side| leaf.coarser_sides & side.bit() != 0);
    let holds = |side: &&Side| leaf.id.neighbour(**side).parent().is_some_and(condition);
    drawn_coarser.filter(holds).fold(0, |bits, side| bits | side.bit())
}

/// Whether any of a patch can be seen: inside the frustum, and not wholly behind the ball that hides what is behind it.
pub fn is_visible(tree: &PatchTree, view: &View, node: &PatchNode) -> bool {
    nearest_and_outside(view, &node.bounds).1 <= 0.0 && !below_horizon(tree, view, node)
}

/// Whether the ball that hides what is behind it hides a whole patch.
fn below_horizon(tree: &PatchTree, view: &View, node: &PatchNode) -> bool {
    let (ball, distance) = (tree.hidden_radius, view.eye.length());
    if !view.horizon || distance <= ball {
        return false;
    }
    let towards = (view.eye.dot(node.centre) / distance).clamp(-1.0, 1.0).acos();
    let nearest = towards - node.spread.min(1.0).acos() - 1e-9;
    let [lowest, highest] = node.heights.map(|height| tree.lattice.radius + f64::from(height));
    // What lies below the ball, under the sea, is hidden where it faces away; what rises above it, where lines to it touch the ball.
    let sunk = (ball.min(lowest) / distance).max(-1.0).acos();
    let risen = if highest > ball { (ball / distance).acos() + (ball / highest).acos() } else { 0.0 };
    nearest > sunk.max(risen)
}
