//! The finest surface that resident patches can be drawn as: what drawn meshes are measured against.
//!
//! Full grids of the leaves of [`finest_cut`], read when a ray first comes near one and kept as long as there is room.

use crate::draw::cut::finest_cut;
use crate::draw::tree::PatchTree;
use crate::globe::lattice::{Lattice, LatticeBox};
use crate::globe::patch::PatchId;
use crate::globe::patch_cache::PatchCache;
use crate::mesh::progressive::PatchMesh;
use crate::query::rays::box_tree::BoxTree;
use crate::query::rays::patch_surface::grouped_grid;
use crate::query::rays::{PatchSurface, Ray};
use crate::store::StoreError;
use glam::DVec3;
use std::collections::HashSet;
use std::sync::{Arc, Mutex, PoisonError};

/// Full grids kept in memory, of some 80 kB each (64 cells). Past it, those unused for longest go.
const MOST_GRIDS: usize = 1536;

/// Reads a patch.
pub type Source = Box<dyn FnMut(PatchId) -> Result<PatchMesh, StoreError> + Send>;

struct Kept {
    source: Source,
    grids: PatchCache<Arc<PatchSurface>>,
}

/// Full grids of patches, shared by all views.
pub struct GridCache {
    kept: Mutex<Kept>,
    lattice: Lattice,
    triangles: Arc<[[u32; 3]]>,
}

impl GridCache {
    /// Grids of a planet; `source` reads a patch.
    pub fn new(tree: &PatchTree, source: Source) -> GridCache {
        let kept = Kept { source, grids: PatchCache::new(MOST_GRIDS) };
        GridCache { kept: Mutex::new(kept), lattice: tree.lattice, triangles: grouped_grid(tree.cells) }
    }

    /// The full grid of a patch.
    ///
    /// # Errors
    /// If the patch cannot be read.
    pub fn grid(&self, id: PatchId) -> Result<Arc<PatchSurface>, StoreError> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(grid) = kept.grids.get(id) {
            return Ok(grid);
        }
        let mesh = (kept.source)(id)?;
        let grid = Arc::new(PatchSurface::of_grid(&mesh, &self.lattice, &self.triangles));
        kept.grids.insert(id, grid.clone());
        Ok(grid)
    }
}

/// The finest surface over one set of resident patches.
pub struct FinestSurface<'a> {
    leaves: Vec<PatchId>,
    known: HashSet<PatchId>,
    boxes: BoxTree,
    grids: &'a GridCache,
}

impl<'a> FinestSurface<'a> {
    /// The surface over the patches that `resident` names.
    pub fn new(tree: &PatchTree, resident: &dyn Fn(PatchId) -> bool, grids: &'a GridCache) -> FinestSurface<'a> {
        let leaves: Vec<PatchId> = finest_cut(tree, resident).leaves.iter().map(|leaf| leaf.id).collect();
        let bounds = |&id: &PatchId| tree.get(id).map_or(LatticeBox::EMPTY, |node| node.space.bounds);
        let boxes: Vec<LatticeBox> = leaves.iter().map(bounds).collect();
        FinestSurface { known: leaves.iter().copied().collect(), boxes: BoxTree::new(&boxes), leaves, grids }
    }

    /// Whether the surface is a patch's full grid where that patch lies.
    pub fn ends_at(&self, id: PatchId) -> bool {
        self.known.contains(&id)
    }

    /// The full grid of a patch.
    ///
    /// # Errors
    /// If the patch cannot be read.
    pub fn grid(&self, id: PatchId) -> Result<Arc<PatchSurface>, StoreError> {
        self.grids.grid(id)
    }

    /// Distance of the surface from the planet's centre in the direction of a point; `None` if there is none.
    ///
    /// # Errors
    /// If a patch cannot be read.
    pub fn radius(&self, through: DVec3) -> Result<Option<f64>, StoreError> {
        let ray = Ray::radial(through);
        let mut failure = None;
        let found = self.boxes.nearest(&ray, |k| match self.grids.grid(self.leaves[k]) {
            Ok(grid) => grid.nearest(&ray),
            Err(error) => {
                failure.get_or_insert(error);
                None
            }
        });
        failure.map_or(Ok(found), Err)
    }
}
