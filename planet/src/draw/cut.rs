//! The patch cut: which patches a view draws. A pure function of (resident patches, view), 2:1 balanced across edges.
//!
//! A patch splits where the viewer is nearer to its bounds than one of two distances: for closure's sake, seen or not, and for the detail of
//! what is seen of it. And only when whatever replaces it is resident, so that missing data makes a coarser picture and never a hole.

use super::tree::{PatchNode, PatchTree, QuarterNode, SeaSpace, Space};
use super::view::View;
use crate::globe::lattice::LatticeBox;
use crate::globe::patch::{PatchId, Side};
use glam::DVec3;
use std::collections::HashMap;

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

/// The patches that a view draws, and what it would rather draw.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    /// Drawn patches, in traversal order.
    pub leaves: Vec<Leaf>,
    /// Patches that the view would draw and that are not resident, the parent's urgency with each (see [`urgency`]; smaller is more urgent).
    pub wanted: Vec<(PatchId, f64)>,
    /// All patches that the view would draw, resident or not.
    pub ideal: Vec<PatchId>,
    /// Their ancestors, with the urgency of whatever is above each.
    pub above: Vec<(PatchId, f64)>,
}

/// Share of the distance at which a patch splits for its texture's sake from which on its texture shows through those of its children; at
/// the whole distance nothing else shows.
pub const FADE_FROM: f64 = 0.65;

/// Whether the textures of a patch of a level can show through those of its children, somewhere in a space.
pub fn shows_through(tree: &PatchTree, view: &View, level: u8, space: &Space) -> bool {
    let [low, high] = [space.bounds.low, space.bounds.high].map(|corner| (corner.as_dvec3() - view.eye).abs());
    low.max(high).length() > FADE_FROM * texture_distance(tree, view, level)
}

/// Level of the textures that a patch of a level is drawn with: the coarsest that is fine enough for what is nearest in its space. Patches
/// split for detail too, where textures need not be finer.
pub fn texture_level(tree: &PatchTree, view: &View, level: u8, space: &Space) -> u8 {
    let nearest = nearest_and_outside(view, &space.bounds).0;
    (0..level).find(|&coarser| nearest >= texture_distance(tree, view, coarser)).unwrap_or(level)
}

/// Whether the textures of a patch itself are drawn somewhere in its space.
pub fn shows_textures(tree: &PatchTree, view: &View, id: PatchId, space: &Space, is_drawn: bool) -> bool {
    texture_level(tree, view, id.level, space) == id.level && (is_drawn || shows_through(tree, view, id.level, space))
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

/// The cut of the whole planet, seen or not. `resident` says which patches can be drawn; the six roots must be.
pub fn cut(tree: &PatchTree, view: &View, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    cut_by(tree, &|id, node| urgency(tree, view, id.level, node), resident)
}

/// The cut of what is in sight: nothing is said of other patches, and none of them need be resident or known. With `underfoot` the ground
/// below the eye counts as in sight. Patches split within `share` of the distances at which they should, 1 unless memory is short.
///
/// Borders are canonical, so where nothing is drawn behind a side no crack can be seen there, and that side counts as one with a neighbour
/// of the same level: the finest that the patch can be.
pub fn cut_in_sight(tree: &PatchTree, view: &View, underfoot: bool, share: f64, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    let urgency = |id: PatchId, node: &PatchNode| urgency_within(tree, view, id, node, share);
    let below = |space: &Space| underfoot && view.eye.dot(space.centre) >= view.eye.length() * space.spread;
    Search::new(tree, &urgency, &|space| is_visible(tree, view, space) || below(space), resident).run()
}

/// The finest surface that the resident patches can be drawn as: every patch splits that can.
pub fn finest_cut(tree: &PatchTree, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    cut_by(tree, &|_, _| 0.0, resident)
}

/// The cut of the whole planet in which the patches split whose urgency is below 1.
pub fn cut_by(tree: &PatchTree, urgency: &dyn Fn(PatchId, &PatchNode) -> f64, resident: &dyn Fn(PatchId) -> bool) -> Cut {
    Search::new(tree, urgency, &|_| true, resident).run()
}

/// Distance over the distance at which a patch of a level splits, the smallest of those for closure's sake, for its texture's and for the
/// detail of its quarters, as far as they are seen: below 1 it splits.
pub fn urgency(tree: &PatchTree, view: &View, level: u8, node: &PatchNode) -> f64 {
    let (nearest, outside) = nearest_and_outside(view, &node.space.bounds);
    let closure = (nearest + view.falloff * outside) / (view.scale * node.closure_wake);
    let texture = |space: &Space| {
        let (nearest, outside) = nearest_and_outside(view, &space.bounds);
        (nearest + SEEN_FALLOFF * outside) / texture_distance(tree, view, level)
    };
    let detail = |quarter: &QuarterNode| {
        let (nearest, outside) = nearest_and_outside(view, &quarter.space.bounds);
        let detail = (nearest + SEEN_FALLOFF * outside) / (view.scale * quarter.detail_wake);
        if detail < 1.0 && below_horizon(tree, view, &quarter.space) {
            f64::INFINITY
        } else {
            detail
        }
    };
    let in_the_dark = |quarter: &&QuarterNode| is_in_the_dark(tree, view, &quarter.space);
    let seen = if node.quarters.iter().any(|quarter| in_the_dark(&quarter)) {
        let lit = node.quarters.iter().filter(|quarter| !in_the_dark(quarter));
        lit.map(|quarter| detail(quarter).min(texture(&quarter.space))).fold(f64::INFINITY, f64::min)
    } else {
        node.quarters.iter().map(detail).fold(texture(&node.space), f64::min)
    };
    if seen < 1.0 && below_horizon(tree, view, &node.space) {
        return closure;
    }
    closure.min(seen)
}

/// The [`urgency`] of a patch where patches split only within a share of the distances at which they should. One around the viewer has no
/// distance that could be too far: as the share falls, the finest of those stop splitting first.
pub fn urgency_within(tree: &PatchTree, view: &View, id: PatchId, node: &PatchNode, share: f64) -> f64 {
    let urgency = urgency(tree, view, id.level, node);
    if share >= 1.0 {
        return urgency;
    }
    urgency.max(0.5f64.powi(24 - i32::from(id.level))) / share
}

/// Finds the ideal cut, then the nearest to it that can be drawn.
///
/// A set of patches that split can be drawn if the parent of each splits too; if across every side the neighbour's parent does (2:1); and
/// if every child that does not split is resident. What is out of sight counts for none of this. Where two sets can be drawn, so can both
/// together: so there is one largest set within the ideal one, whatever order it is looked for in.
struct Search<'a> {
    tree: &'a PatchTree,
    urgency: &'a dyn Fn(PatchId, &PatchNode) -> f64,
    seen: &'a dyn Fn(&Space) -> bool,
    resident: &'a dyn Fn(PatchId) -> bool,
    in_sight: HashMap<PatchId, bool>,
    /// Patches that split, and how urgently.
    split: HashMap<PatchId, f64>,
}

impl<'a> Search<'a> {
    fn new(
        tree: &'a PatchTree,
        urgency: &'a dyn Fn(PatchId, &PatchNode) -> f64,
        seen: &'a dyn Fn(&Space) -> bool,
        resident: &'a dyn Fn(PatchId) -> bool,
    ) -> Search<'a> {
        Search { tree, urgency, seen, resident, in_sight: HashMap::new(), split: HashMap::new() }
    }

    fn run(mut self) -> Cut {
        let mut cut = Cut::default();
        PatchId::roots().for_each(|root| self.refine(root));
        let tree = self.tree;
        // What is not known yet may turn out to split.
        self.drop_unsupported(&|search, id| search.is_balanced(id, &|parent| tree.get(parent).is_none()));
        PatchId::roots().for_each(|root| self.list_ideal(root, 0.0, &mut cut));
        if !cut.wanted.is_empty() {
            self.stand_in(cut.wanted.iter().map(|(id, _)| *id).collect());
            self.drop_unsupported(&|search, id| search.is_balanced(id, &|_| false) && search.is_covered(id));
        }
        PatchId::roots().for_each(|root| self.collect(root, &mut cut.leaves));
        cut
    }

    /// Whether any of a patch is in sight, as far as its parent knows.
    fn is_in_sight(&mut self, id: PatchId) -> bool {
        if let Some(&known) = self.in_sight.get(&id) {
            return known;
        }
        let seen = match id.parent() {
            None => self.tree.get(id).is_none_or(|node| (self.seen)(&node.space)),
            Some(parent) => {
                let node = self.tree.get(parent);
                self.is_in_sight(parent) && node.is_none_or(|node| (self.seen)(&node.quarters[id.quarter()].space))
            }
        };
        self.in_sight.insert(id, seen);
        seen
    }

    fn children_in_sight(&mut self, id: PatchId) -> impl Iterator<Item = PatchId> + use<> {
        let children = id.children().unwrap_or([id; 4]);
        let seen = children.map(|child| child != id && self.is_in_sight(child));
        children.into_iter().zip(seen).filter_map(|(child, seen)| seen.then_some(child))
    }

    /// Parents of a patch's neighbours, as far as they are in sight: for balance, they split if the patch does.
    fn neighbours_parents(&mut self, id: PatchId) -> impl Iterator<Item = PatchId> + use<> {
        let parents = Side::ALL.map(|side| id.neighbour(side).parent().filter(|&parent| self.is_in_sight(parent)));
        parents.into_iter().flatten()
    }

    fn can_split(&mut self, id: PatchId) -> bool {
        let tree = self.tree;
        tree.get(id).is_some() && tree.can_split_into(id, &mut |child| self.is_in_sight(child))
    }

    /// Splits what a view wants split, and what balance then asks for.
    fn refine(&mut self, id: PatchId) {
        let Some(node) = self.tree.get(id).filter(|_| self.is_in_sight(id)) else { return };
        let urgency = (self.urgency)(id, node);
        if urgency < 1.0 && self.can_split(id) {
            self.split_balanced(id, urgency, &mut Vec::new());
            self.children_in_sight(id).for_each(|child| self.refine(child));
        }
    }

    /// Splits a patch and what balance then asks for; says which those were.
    fn split_balanced(&mut self, id: PatchId, urgency: f64, added: &mut Vec<PatchId>) {
        if self.split.contains_key(&id) || !self.can_split(id) {
            return;
        }
        self.split.insert(id, urgency);
        added.push(id);
        self.neighbours_parents(id).for_each(|parent| self.split_balanced(parent, urgency, added));
    }

    /// Where a patch is not resident but all its children are, they stand in for it; and so for whatever has to split beside them then.
    fn stand_in(&mut self, mut gaps: Vec<PatchId>) {
        while let Some(gap) = gaps.pop() {
            if !self.split.contains_key(&gap) && self.has_stand_ins(gap) {
                let mut added = Vec::new();
                self.split_balanced(gap, 1.0, &mut added);
                for id in added {
                    let missing = |child: &PatchId| !(self.resident)(*child);
                    gaps.extend(self.children_in_sight(id).filter(missing));
                }
            }
        }
    }

    fn has_stand_ins(&mut self, id: PatchId) -> bool {
        self.can_split(id) && self.children_in_sight(id).all(|child| (self.resident)(child) || self.has_stand_ins(child))
    }

    /// Whether the parent of a patch splits, and those of its neighbours do or `may`.
    fn is_balanced(&mut self, id: PatchId, may: &dyn Fn(PatchId) -> bool) -> bool {
        let splits = |id: &PatchId| self.split.contains_key(id);
        let parent_splits = id.parent().is_none_or(|parent| splits(&parent));
        parent_splits && self.neighbours_parents(id).all(|parent| self.split.contains_key(&parent) || may(parent))
    }

    /// Whether all that replaces a patch can be drawn.
    fn is_covered(&mut self, id: PatchId) -> bool {
        self.children_in_sight(id).all(|child| self.split.contains_key(&child) || (self.resident)(child))
    }

    /// Lets patches go from the split set until a condition holds for all that are left.
    fn drop_unsupported(&mut self, holds: &dyn Fn(&mut Self, PatchId) -> bool) {
        let mut doubtful: Vec<PatchId> = self.split.keys().copied().collect();
        while let Some(id) = doubtful.pop() {
            if self.split.contains_key(&id) && !holds(self, id) {
                self.split.remove(&id);
                let around = Side::ALL.into_iter().map(|side| id.neighbour(side)).chain([id]);
                doubtful.extend(around.filter_map(PatchId::children).flatten());
                doubtful.extend(id.parent());
            }
        }
    }

    fn list_ideal(&mut self, id: PatchId, urgency: f64, cut: &mut Cut) {
        if !self.is_in_sight(id) {
            return;
        }
        if let Some(&own) = self.split.get(&id) {
            cut.above.push((id, urgency));
            self.children_in_sight(id).for_each(|child| self.list_ideal(child, own, cut));
            return;
        }
        cut.ideal.push(id);
        if !(self.resident)(id) {
            cut.wanted.push((id, urgency));
        }
    }

    fn collect(&mut self, id: PatchId, leaves: &mut Vec<Leaf>) {
        if !self.is_in_sight(id) {
            return;
        }
        if self.split.contains_key(&id) {
            self.children_in_sight(id).for_each(|child| self.collect(child, leaves));
            return;
        }
        let mut coarser = |side: Side| {
            let parent = id.neighbour(side).parent().filter(|_| id.on_parent_boundary(side));
            parent.is_some_and(|parent| self.is_in_sight(parent) && !self.split.contains_key(&parent))
        };
        let coarser_sides = Side::ALL.into_iter().filter(|&side| coarser(side)).fold(0, |bits, side| bits | side.bit());
        leaves.push(Leaf { id, coarser_sides });
    }
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

/// Whether any of what is in a space can be seen: inside the frustum, and not wholly behind the ball that hides what is behind it.
pub fn is_visible(tree: &PatchTree, view: &View, space: &Space) -> bool {
    nearest_and_outside(view, &space.bounds).1 <= 0.0 && !below_horizon(tree, view, space)
}

/// Whether all of a space lies so deep in the sea that a view from above the sea shows nothing of it but that it is deep.
fn is_in_the_dark(tree: &PatchTree, view: &View, space: &Space) -> bool {
    let deep = |sea: SeaSpace| view.eye.length() > sea.surface && tree.lattice.radius + f64::from(space.heights[1]) < sea.dark;
    tree.sea.is_some_and(deep)
}

/// Whether any of a patch can be seen, as far as its ancestors know: what [`cut_in_sight`] goes by.
pub fn is_in_sight(tree: &PatchTree, view: &View, id: PatchId) -> bool {
    Search::new(tree, &|_, _| f64::INFINITY, &|space| is_visible(tree, view, space), &|_| false).is_in_sight(id)
}

/// Whether the ball that hides what is behind it hides all of a space.
fn below_horizon(tree: &PatchTree, view: &View, space: &Space) -> bool {
    let (ball, distance) = (tree.hidden_radius, view.eye.length());
    if !view.horizon || distance <= ball {
        return false;
    }
    let towards = (view.eye.dot(space.centre) / distance).clamp(-1.0, 1.0).acos();
    let nearest = towards - space.spread.min(1.0).acos() - 1e-9;
    let [lowest, highest] = space.heights.map(|height| tree.lattice.radius + f64::from(height));
    // What lies below the ball, under the sea, is hidden where it faces away; what rises above it, where lines to it touch the ball.
    let sunk = (ball.min(lowest) / distance).max(-1.0).acos();
    let risen = if highest > ball { (ball / distance).acos() + (ball / highest).acos() } else { 0.0 };
    nearest > sunk.max(risen)
}
