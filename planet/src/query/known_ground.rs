//! All patch grids that are known, and the ground over a direction.
//!
//! Direct addressing: face, then quarter by quarter down to the leaf, then the cell and its two triangles. No search structure.

use super::patch_grid::PatchGrid;
use super::rays::patch_surface::grouped_grid;
use crate::globe::lattice::Lattice;
use crate::globe::patch::{PatchId, MAX_LEVEL};
use crate::globe::sphere::{warp_component, Face};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;

/// All four children.
const WHOLE: u8 = 0b1111;

/// Ground over a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundHeight {
    /// Metres above the datum.
    pub height: f64,
    /// Level of the patch that says so.
    pub level: u8,
    /// Mean distance of its samples in metres: between them the ground is flat triangles.
    pub spacing: f64,
}

/// The ground as far as it is known: a set of patch grids of one planet.
pub struct KnownGround {
    /// Lattice of the planet.
    pub lattice: Lattice,
    pub(super) triangles: Arc<[[u32; 3]]>,
    cells: u32,
    grids: HashMap<PatchId, PatchGrid>,
    /// Which children of a patch are known, one bit each.
    children: HashMap<PatchId, u8>,
    /// Highest sample of all grids that ever were known, lattice units above the datum.
    pub(super) highest: i32,
}

impl KnownGround {
    /// Nothing known yet of a planet with patches of `cells` cells a side.
    pub fn new(lattice: Lattice, cells: u32) -> KnownGround {
        let (grids, children) = (HashMap::new(), HashMap::new());
        KnownGround { lattice, triangles: grouped_grid(cells), cells, grids, children, highest: i32::MIN }
    }

    /// Makes a patch known. It takes effect once its three siblings are known too, as a patch is drawn only then; whole faces at once.
    /// A grid of another lattice or with another number of cells is not of this planet: it is not taken, and false returned.
    pub fn insert(&mut self, grid: PatchGrid) -> bool {
        if grid.cells() != self.cells || grid.lattice != self.lattice {
            return false;
        }
        if let Some(parent) = grid.id.parent() {
            *self.children.entry(parent).or_insert(0) |= bit(grid.id);
        }
        self.highest = self.highest.max(grid.highest);
        self.grids.insert(grid.id, grid);
        true
    }

    /// Forgets a patch. Where it and its siblings were, their parent answers again.
    pub fn remove(&mut self, id: PatchId) {
        if self.grids.remove(&id).is_none() {
            return;
        }
        if let Some(parent) = id.parent() {
            let left = self.children.get(&parent).map_or(0, |known| known & !bit(id));
            if left == 0 {
                self.children.remove(&parent);
            } else {
                self.children.insert(parent, left);
            }
        }
    }

    /// Forgets the patches that a condition names.
    pub fn forget(&mut self, condition: impl Fn(PatchId) -> bool) {
        let going: Vec<PatchId> = self.grids.keys().copied().filter(|&id| condition(id)).collect();
        going.into_iter().for_each(|id| self.remove(id));
    }

    /// Whether a patch was made known.
    pub fn contains(&self, id: PatchId) -> bool {
        self.grids.contains_key(&id)
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.grids.len()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.grids.is_empty()
    }

    /// Mean distance in metres of the samples of a level.
    pub fn spacing(&self, level: u8) -> f64 {
        self.lattice.sample_spacing(self.cells, level) * self.lattice.unit
    }

    /// The ground in a direction of any length but zero; `None` where nothing is known, or for a direction that is none. On the border
    /// of patches it may be that of either, which differ by the rounding of the lattice or, where levels differ, by what the finer one
    /// adds.
    pub fn height_at(&self, direction: DVec3) -> Option<GroundHeight> {
        self.height_to_level(direction, MAX_LEVEL)
    }

    /// [`KnownGround::height_at`] of patches of at most a level.
    pub fn height_to_level(&self, direction: DVec3, most: u8) -> Option<GroundHeight> {
        let direction = direction.try_normalize()?;
        let grid = self.grids.get(&self.leaf(direction, most))?;
        let height = (grid.radius(direction)? - self.lattice.radius) * self.lattice.unit;
        Some(GroundHeight { height, level: grid.id.level, spacing: self.spacing(grid.id.level) })
    }

    /// The patch of at most a level that answers for a direction; a whole face where nothing is known.
    pub(super) fn leaf(&self, direction: DVec3, most: u8) -> PatchId {
        let face = Face::containing(direction);
        let (u, v) = face.project(direction);
        let (column, row) = face.grid_axes();
        let mut id = PatchId { face, level: 0, x: 0, y: 0 };
        while id.level < most && self.children.get(&id) == Some(&WHOLE) {
            let middle = id.point(1, 1, 2);
            let (right, upper) = (u >= warp_component(middle[column]), v >= warp_component(middle[row]));
            id = PatchId { face, level: id.level + 1, x: 2 * id.x + u32::from(right), y: 2 * id.y + u32::from(upper) };
        }
        id
    }

    pub(super) fn grid(&self, id: PatchId) -> Option<&PatchGrid> {
        self.grids.get(&id)
    }
}

/// The bit of a patch among its siblings.
fn bit(id: PatchId) -> u8 {
    1 << (id.y % 2 * 2 + id.x % 2)
}
