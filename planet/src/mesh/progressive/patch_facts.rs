//! What is known of a patch without its vertices.

use crate::globe::lattice::LatticeBox;

/// Facts of one patch: the mesh, the index of a planet file and its records hold them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFacts {
    /// Box around all vertices.
    pub bounds: LatticeBox,
    /// Lowest and highest vertex, lattice units above the datum.
    pub heights: [i32; 2],
    /// Largest radial distance in lattice units of the next level's samples from this patch's full grid.
    pub deviation: f64,
    /// Largest wake that a vertex of its children has on its sides where it has none itself, lattice units.
    pub child_wake: f64,
}
