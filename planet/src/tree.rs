//! What is known of all stored patches without reading them: bounds, and how near a viewer must be for each to split.

use crate::lattice::{Lattice, LatticeBox};
use crate::patch::PatchId;
use crate::progressive::PatchMesh;
use crate::store::PatchRecord;
use crate::wake::MORPH_REACH;
use crate::{DEVIATION_SHARE, KAPPA};
use glam::DVec3;
use std::collections::HashMap;

/// Facts of one stored patch, see [`crate::progressive::PatchMesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFacts {
    /// Which patch.
    pub id: PatchId,
    /// Box around its vertices.
    pub bounds: LatticeBox,
    /// Lowest and highest vertex in lattice units above the datum.
    pub heights: [i32; 2],
    /// Radial distance of the next level's samples from its grid, lattice units.
    pub deviation: f64,
    /// Largest own wake of its odd vertices on the parent's boundary, lattice units.
    pub odd_wake: f64,
}

impl From<&PatchMesh> for PatchFacts {
    fn from(mesh: &PatchMesh) -> PatchFacts {
        let PatchMesh { id, bounds, heights, deviation, odd_wake, .. } = *mesh;
        PatchFacts { id, bounds, heights, deviation, odd_wake }
    }
}

impl From<&PatchRecord> for PatchFacts {
    fn from(record: &PatchRecord) -> PatchFacts {
        let PatchRecord { id, bounds, heights, deviation, odd_wake, .. } = *record;
        PatchFacts { id, bounds, heights, deviation, odd_wake }
    }
}

/// A stored patch within its quadtree.
#[derive(Clone, Copy, Debug)]
pub struct PatchNode {
    /// Box around its own and all stored descendants' vertices.
    pub bounds: LatticeBox,
    /// Highest vertex of it and its descendants, lattice units above the datum.
    pub highest: i32,
    /// Wsplit: a viewer nearer to `bounds` than this times the view's scale needs the children. 0 without children.
    pub split_wake: f64,
    /// Whether all four children are stored.
    pub has_children: bool,
    /// Direction of its middle.
    pub centre: DVec3,
    /// Cosine of the angle between its middle and its farthest corner.
    pub spread: f64,
    /// Deviation from the finest stored descendants, lattice units.
    deviation: f64,
    own: PatchFacts,
}

/// All stored patches.
pub struct PatchTree {
    nodes: HashMap<PatchId, PatchNode>,
    /// Lattice of the planet.
    pub lattice: Lattice,
    /// Grid cells a side.
    pub cells: u32,
    /// Lowest vertex of the planet, lattice units above the datum.
    pub lowest: i32,
}

impl PatchTree {
    /// Builds the tree, finest patches first.
    pub fn new(lattice: Lattice, cells: u32, facts: impl IntoIterator<Item = PatchFacts>) -> PatchTree {
        let mut all: Vec<PatchFacts> = facts.into_iter().collect();
        all.sort_by_key(|f| (std::cmp::Reverse(f.id.level), f.id));
        let lowest = all.iter().map(|f| f.heights[0]).min().unwrap_or(0);
        let mut tree = PatchTree { nodes: HashMap::with_capacity(all.len()), lattice, cells, lowest };
        for own in all {
            let node = tree.node_of(own);
            tree.nodes.insert(own.id, node);
        }
        tree
    }

    fn node_of(&self, own: PatchFacts) -> PatchNode {
        let centre = own.id.centre();
        let corner = |a: i32, b: i32| crate::sphere::direction(own.id.point(a, b, 1)).dot(centre);
        let spread = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)].into_iter().fold(1.0, f64::min);
        let mut node = PatchNode {
            bounds: own.bounds,
            highest: own.heights[1],
            split_wake: 0.0,
            has_children: false,
            centre,
            spread,
            deviation: 0.0,
            own,
        };
        let children: Option<Vec<&PatchNode>> =
            own.id.children().and_then(|ids| ids.iter().map(|id| self.nodes.get(id)).collect());
        if let Some(children) = children {
            node.has_children = true;
            let deepest = children.iter().map(|c| c.deviation).fold(0.0, f64::max);
            node.deviation = own.deviation + deepest;
            let odd = children.iter().map(|c| c.own.odd_wake).fold(0.0, f64::max);
            node.split_wake = (MORPH_REACH * odd).max(node.deviation / (DEVIATION_SHARE * KAPPA));
            for child in children {
                node.bounds = node.bounds.union(child.bounds);
                node.highest = node.highest.max(child.highest);
            }
        }
        node
    }

    /// A stored patch.
    pub fn get(&self, id: PatchId) -> Option<&PatchNode> {
        self.nodes.get(&id)
    }

    /// Number of stored patches.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether nothing is stored.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Ids of all stored patches, in no order.
    pub fn ids(&self) -> impl Iterator<Item = PatchId> + '_ {
        self.nodes.keys().copied()
    }

    /// Mean size of a texel of a level's textures, in lattice units.
    pub fn texel_size(&self, level: u8) -> f64 {
        self.lattice.sample_spacing(2 * self.cells, level)
    }
}
