//! A patch that is ready to be drawn.

use super::layout::PatchVertex;
use super::work::{Reach, Work};
use crate::globe::lattice::Lattice;
use crate::mesh::progressive::{IndexLevels, PatchMesh};

/// A patch with everything the checks and the run time need.
pub struct LoadedPatch {
    /// The progressive mesh.
    pub mesh: PatchMesh,
    /// Its vertices as the GPU sees them.
    pub vertices: Vec<PatchVertex>,
    /// Its triangle lists.
    pub lists: IndexLevels,
    /// What decides how much of it a view looks at.
    pub reach: Reach,
}

impl LoadedPatch {
    /// Prepares a patch for drawing.
    pub fn new(mesh: PatchMesh, lattice: &Lattice) -> LoadedPatch {
        let vertices = PatchVertex::of_patch(&mesh, lattice);
        let lists = IndexLevels::new(&mesh);
        let reach = Reach::new(&vertices, mesh.cells, &lists);
        LoadedPatch { mesh, vertices, lists, reach }
    }

    /// The triangles that emission begins with.
    pub fn triangles(&self, work: &Work) -> Vec<[u16; 3]> {
        work.triangles.iter().flat_map(|run| &self.lists.triangles[run.start as usize..run.end as usize]).copied().collect()
    }
}
