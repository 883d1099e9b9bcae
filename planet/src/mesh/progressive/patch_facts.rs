//! What is known of a patch without its vertices.

use crate::globe::lattice::LatticeBox;

/// Facts of one patch: the mesh, the index of a planet file and its records hold them. They follow from its samples alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFacts {
    /// Box around all vertices.
    pub bounds: LatticeBox,
    /// Lowest and highest vertex, lattice units above the datum.
    pub heights: [i32; 2],
    /// Largest wake that a vertex of its children has on its sides where it has none itself, lattice units.
    pub child_wake: f64,
    /// What is known of the next level's samples in each quarter, in the order of [`crate::globe::patch::PatchId::children`].
    pub quarters: [Quarter; 4],
}

/// The next level's samples in a quarter of a patch, its sides included: the vertices of one child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quarter {
    /// Lowest and highest of them, lattice units above the datum.
    pub heights: [i32; 2],
    /// Their largest radial distance in lattice units from the patch's full grid.
    pub deviation: f64,
}

impl PatchFacts {
    /// Largest radial distance in lattice units of the next level's samples from this patch's full grid.
    pub fn deviation(&self) -> f64 {
        self.quarters.iter().map(|quarter| quarter.deviation).fold(0.0, f64::max)
    }
}
