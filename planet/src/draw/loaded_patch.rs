//! A patch that is ready to be drawn.

use super::layout::PatchVertex;
use super::work::{Reach, Work};
use crate::globe::lattice::Lattice;
use crate::mesh::progressive::{IndexLevels, MeshPrefix, PatchMesh};

/// A patch with everything the checks and the run time need.
pub struct LoadedPatch {
    /// The progressive mesh, as far as it is there.
    pub mesh: PatchMesh,
    /// For every grid position the vertex index that it falls to, as in [`MeshPrefix`].
    pub falls: Vec<u16>,
    /// Its vertices as the GPU sees them.
    pub vertices: Vec<PatchVertex>,
    /// Its triangle lists.
    pub lists: IndexLevels,
    /// What decides how much of it a view looks at.
    pub reach: Reach,
}

impl LoadedPatch {
    /// Prepares a patch for drawing, whole or as far as its vertices are there.
    pub fn new(mesh: impl Into<MeshPrefix>, lattice: &Lattice) -> LoadedPatch {
        let prefix = mesh.into();
        let vertices = PatchVertex::of_patch(&prefix.mesh, lattice);
        let lists = IndexLevels::new(&prefix);
        let reach = Reach::new(&vertices, &prefix, &lists);
        LoadedPatch { mesh: prefix.mesh, falls: prefix.falls, vertices, lists, reach }
    }

    /// The triangles that emission begins with.
    pub fn triangles(&self, work: &Work) -> Vec<[u16; 3]> {
        work.triangles.iter().flat_map(|run| &self.lists.triangles[run.start as usize..run.end as usize]).copied().collect()
    }
}
