//! What is known of all patches without reading them: bounds, and how near a viewer must be for each to split.

use crate::globe::lattice::{Lattice, LatticeBox};
use crate::globe::patch::{PatchId, MAX_LEVEL};
use crate::mesh::certificate::{DEVIATION_BELOW, DEVIATION_SHARE, KAPPA};
use crate::mesh::progressive::PatchFacts;
use crate::mesh::wake::MORPH_REACH;
use glam::DVec3;
use std::collections::HashMap;

/// A known patch within its quadtree: what follows from its own facts alone, whatever is known below it.
#[derive(Clone, Copy, Debug)]
pub struct PatchNode {
    /// Box around its own vertices and those of whatever finer patches there may be.
    pub bounds: LatticeBox,
    /// Lowest and highest of all these vertices, lattice units above the datum.
    pub heights: [i32; 2],
    /// A viewer nearer to `bounds` than this times the view's scale needs the children, seen or not: vertices that only they have are
    /// awake on the patch's sides, where seen patches may lie.
    pub closure_wake: f64,
    /// A viewer nearer than this times the view's scale needs them if the patch is seen: they deviate from its grid by more than their share of the tolerance.
    pub detail_wake: f64,
    /// Direction of its middle.
    pub centre: DVec3,
    /// Cosine of the angle between its middle and its farthest corner.
    pub spread: f64,
}

impl PatchNode {
    fn new(id: PatchId, own: &PatchFacts) -> PatchNode {
        let centre = id.centre();
        let corner = |a: i32, b: i32| crate::globe::sphere::direction(id.point(a, b, 1)).dot(centre);
        let margin = (DEVIATION_BELOW * own.deviation).ceil() as i32;
        PatchNode {
            bounds: own.bounds.widened(margin),
            heights: [own.heights[0].saturating_sub(margin), own.heights[1].saturating_add(margin)],
            closure_wake: MORPH_REACH * own.child_wake,
            detail_wake: own.deviation / (DEVIATION_SHARE * KAPPA),
            centre,
            spread: [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)].into_iter().fold(1.0, f64::min),
        }
    }
}

/// All known patches: those stored, and those built since.
pub struct PatchTree {
    nodes: HashMap<PatchId, PatchNode>,
    /// Level down to which patches can be built that are not known yet.
    finest_built: Option<u8>,
    /// Lattice of the planet.
    pub lattice: Lattice,
    /// Grid cells a side.
    pub cells: u32,
    /// Radius in lattice units of a ball that is wholly inside the ground or the sea: it hides what is behind it.
    pub hidden_radius: f64,
}

impl PatchTree {
    /// The tree of stored patches. `lowest` is a height in lattice units above the datum that no ground, or else the sea, is below:
    /// it follows from the planet alone, or what is culled would depend on which patches are known.
    pub fn new(lattice: Lattice, cells: u32, lowest: f64, facts: impl IntoIterator<Item = (PatchId, PatchFacts)>) -> PatchTree {
        // Rounding to the lattice, and straight edges between samples on the sea's own sphere.
        let hidden_radius = lattice.radius + lowest - 2.0;
        let mut tree = PatchTree { nodes: HashMap::new(), finest_built: None, lattice, cells, hidden_radius };
        facts.into_iter().for_each(|(id, own)| tree.insert(id, &own));
        tree
    }

    /// The same tree for a planet whose patches can be built when they are wanted, down to a level.
    pub fn built_to(mut self, level: u8) -> PatchTree {
        self.finest_built = Some(level.min(MAX_LEVEL));
        self
    }

    /// Adds a patch.
    pub fn insert(&mut self, id: PatchId, facts: &PatchFacts) {
        self.nodes.insert(id, PatchNode::new(id, facts));
    }

    /// Forgets a patch that can be built again.
    pub fn forget(&mut self, id: PatchId) {
        if self.finest_built.is_some() {
            self.nodes.remove(&id);
        }
    }

    /// Whether a patch can give way to its children: they are all known, or can be built.
    pub fn can_split(&self, id: PatchId) -> bool {
        let known = || id.children().is_some_and(|ids| ids.iter().all(|child| self.nodes.contains_key(child)));
        self.finest_built.is_some_and(|level| id.level < level) || known()
    }

    /// A known patch.
    pub fn get(&self, id: PatchId) -> Option<&PatchNode> {
        self.nodes.get(&id)
    }

    /// Number of known patches.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Ids of all known patches, in no order.
    pub fn ids(&self) -> impl Iterator<Item = PatchId> + '_ {
        self.nodes.keys().copied()
    }

    /// Mean size of a texel of a level's textures, in lattice units.
    pub fn texel_size(&self, level: u8) -> f64 {
        self.lattice.sample_spacing(2 * self.cells, level)
    }
}
