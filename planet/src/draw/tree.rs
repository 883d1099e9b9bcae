//! What is known of all patches without reading them: bounds, and how near a viewer must be for each to split.

use crate::globe::lattice::{Lattice, LatticeBox};
use crate::globe::patch::{PatchId, MAX_LEVEL};
use crate::ground::texture::SHORE_RANGE;
use crate::mesh::certificate::{DEVIATION_BELOW, DEVIATION_SHARE, KAPPA};
use crate::mesh::progressive::{PatchFacts, Quarter};
use crate::mesh::wake::MORPH_REACH;
use glam::DVec3;
use std::collections::HashMap;

/// A known patch within its quadtree: what follows from its own facts alone, whatever is known below it.
#[derive(Clone, Copy, Debug)]
pub struct PatchNode {
    /// Where its own vertices are, and those of whatever finer patches there may be.
    pub space: Space,
    /// A viewer nearer to its bounds than this times the view's scale needs the children: vertices that only they have are awake on the
    /// patch's sides.
    pub closure_wake: f64,
    /// Its quarters, in the order of [`PatchId::children`].
    pub quarters: [QuarterNode; 4],
}

/// A quarter of a known patch: what is known of a child before the child is.
#[derive(Clone, Copy, Debug)]
pub struct QuarterNode {
    /// Where the child's vertices are, and those of whatever finer patches there may be.
    pub space: Space,
    /// A viewer nearer to the quarter than this times the view's scale needs the children if it is seen: they deviate from the patch's grid
    /// by more than their share of the tolerance.
    pub detail_wake: f64,
}

/// Where the ground of a patch may be, all finer levels included.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    /// A box around it.
    pub bounds: LatticeBox,
    /// Lowest and highest of it, lattice units above the datum.
    pub heights: [i32; 2],
    /// Direction of the patch's middle.
    pub centre: DVec3,
    /// Cosine of the angle between its middle and its farthest corner.
    pub spread: f64,
}

impl Space {
    /// Around samples of a patch between two heights, from which finer levels deviate by so much more than the next one does.
    fn new(id: PatchId, heights: [i32; 2], deviation: f64, bounds: impl FnOnce(&Space) -> LatticeBox) -> Space {
        let centre = id.centre();
        let spread = corners(id).into_iter().map(|corner| corner.dot(centre)).fold(1.0, f64::min);
        let margin = (DEVIATION_BELOW * deviation).ceil() as i32;
        let mut space = Space { bounds: LatticeBox::EMPTY, heights, centre, spread };
        space.bounds = bounds(&space).widened(margin);
        space.heights = [heights[0].saturating_sub(margin), heights[1].saturating_add(margin)];
        space
    }
}

/// Directions of a patch's corners.
fn corners(id: PatchId) -> [DVec3; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| crate::globe::sphere::direction(id.point(a, b, 1)))
}

/// A box around all of a patch's ground between its two heights. Between its corners the sphere bulges out of their hull by at most what
/// it does over the whole cone, on either side.
fn box_between(lattice: &Lattice, id: PatchId, space: &Space) -> LatticeBox {
    let [low, high] = space.heights.map(|height| lattice.radius + f64::from(height));
    let mut bounds = LatticeBox::EMPTY;
    for corner in corners(id) {
        [low, high].into_iter().for_each(|radius| bounds.include((corner * radius).round().as_ivec3()));
    }
    bounds.widened((2.0 * high * (1.0 - space.spread)).ceil() as i32 + 1)
}

impl PatchNode {
    fn new(lattice: &Lattice, id: PatchId, own: &PatchFacts) -> PatchNode {
        // At the finest level, where nothing splits, the patch stands for its quarters.
        let children = id.children().unwrap_or([id; 4]);
        let quarter = |k: usize| {
            let Quarter { heights, deviation } = own.quarters[k];
            let space = Space::new(children[k], heights, deviation, |space| box_between(lattice, children[k], space));
            QuarterNode { space, detail_wake: deviation / (DEVIATION_SHARE * KAPPA) }
        };
        PatchNode {
            space: Space::new(id, own.heights, own.deviation(), |_| own.bounds),
            closure_wake: MORPH_REACH * own.child_wake,
            quarters: std::array::from_fn(quarter),
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
    /// The planet's sea, if it has one.
    pub sea: Option<SeaSpace>,
}

/// Where the sea is, and how deep one sees into it: distances from the planet's centre in lattice units.
#[derive(Clone, Copy, Debug)]
pub struct SeaSpace {
    /// Its surface.
    pub surface: f64,
    /// Where light no longer reaches: what the ground is like below this cannot be seen from above the surface.
    pub dark: f64,
}

impl PatchTree {
    /// The tree of stored patches. `lowest` is a height in lattice units above the datum that no ground, or else the sea, is below:
    /// it follows from the planet alone, or what is culled would depend on which patches are known.
    pub fn new(lattice: Lattice, cells: u32, lowest: f64, facts: impl IntoIterator<Item = (PatchId, PatchFacts)>) -> PatchTree {
        // Rounding to the lattice, and straight edges between samples on the sea's own sphere.
        let hidden_radius = lattice.radius + lowest - 2.0;
        let mut tree = PatchTree { nodes: HashMap::new(), finest_built: None, lattice, cells, hidden_radius, sea: None };
        facts.into_iter().for_each(|(id, own)| tree.insert(id, &own));
        tree
    }

    /// The same tree for a planet with a sea whose surface lies at a height in metres above the datum. No ground out of which the sea is kept
    /// lies below `dry_m`.
    pub fn with_sea(mut self, level_m: f64, dry_m: f64) -> PatchTree {
        let radius = |metres: f64| self.lattice.radius + metres / self.lattice.unit;
        self.sea = Some(SeaSpace { surface: radius(level_m), dark: radius((level_m - SHORE_RANGE).min(dry_m)) });
        self
    }

    /// The same tree for a planet whose patches can be built when they are wanted, down to a level.
    pub fn built_to(mut self, level: u8) -> PatchTree {
        self.finest_built = Some(level.min(MAX_LEVEL));
        self
    }

    /// The same planet's tree without any patch.
    pub fn emptied(&self) -> PatchTree {
        PatchTree { nodes: HashMap::new(), ..*self }
    }

    /// This tree, with all that another tree of the same lattice knows of the patches that a condition names.
    pub fn with_known(mut self, other: &PatchTree, known: impl Fn(PatchId) -> bool) -> PatchTree {
        self.nodes.extend(other.nodes.iter().filter(|(id, _)| known(**id)).map(|(id, node)| (*id, *node)));
        self
    }

    /// What would be known of a patch with these facts.
    pub fn node(&self, id: PatchId, facts: &PatchFacts) -> PatchNode {
        PatchNode::new(&self.lattice, id, facts)
    }

    /// Adds a patch.
    pub fn insert(&mut self, id: PatchId, facts: &PatchFacts) {
        self.nodes.insert(id, self.node(id, facts));
    }

    /// Forgets patches that can be surveyed again, but for those that a condition names.
    pub fn forget_but(&mut self, keep: impl Fn(PatchId) -> bool) {
        if self.finest_built.is_some() {
            self.nodes.retain(|id, _| keep(*id));
        }
    }

    /// Whether a patch can give way to its children: they are all known, or can be built.
    pub fn can_split(&self, id: PatchId) -> bool {
        self.can_split_into(id, &mut |_| true)
    }

    /// Whether a patch can give way to those of its children that count, if it has any.
    pub(crate) fn can_split_into(&self, id: PatchId, counts: &mut dyn FnMut(PatchId) -> bool) -> bool {
        let is_known = |child: &PatchId| self.nodes.contains_key(child);
        let children = id.children().filter(|children| children.iter().any(is_known));
        let mut known = || children.is_some_and(|children| children.into_iter().all(|c| is_known(&c) || !counts(c)));
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
