//! The classics of progressive meshes under their own names: a triangle mesh with face adjacency, edge collapses and vertex
//! splits, a progressive mesh that goes both ways (Hoppe 1996), and costs that choose what to collapse first. In: plain
//! heightfields. Out: progressive meshes to study, to compare with and to learn from; planets are built by
//! [`crate::decimate`].

mod cost;
mod decimate;
mod error;
mod levels;
mod mesh;
mod outline;
mod progressive_mesh;
mod quadric;
mod split;
mod spring;
mod validate;

pub use error::ClassicError;
pub use levels::{Level, Levels};
pub use mesh::{FaceMesh, Star, NONE};
pub use progressive_mesh::ProgressiveMesh;
pub use split::{Refusal, VertexSplit};
pub use validate::{euler_characteristic, Violation};

use crate::plain;
use crate::Heightfield;
use decimate::Decimation;
use error::refuse_gaps;
use outline::Outline;

/// What chooses the edge that collapses next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Measured error: half-edge collapses whose error was measured at every sample that they touch ([`crate::plain`]).
    Certified,
    /// Quadric error metrics (Garland and Heckbert 1997): squared distances to the planes of merged faces.
    Quadric,
    /// Anchor springs (after Sklyar): energy of springs to merged vertices, weighted by curvature.
    Spring,
}

impl Cost {
    /// All of them.
    pub const ALL: [Cost; 3] = [Cost::Certified, Cost::Quadric, Cost::Spring];

    /// A word for it.
    pub fn name(self) -> &'static str {
        match self {
            Cost::Certified => "certified",
            Cost::Quadric => "quadric",
            Cost::Spring => "spring",
        }
    }
}

/// The progressive mesh of a heightfield, from the two triangles of its corners to all samples, coarsened in the order of
/// `cost`. It begins at its coarsest. `progress` is told the collapses done, now and then; in all there are as many as
/// samples besides the corners.
///
/// # Errors
/// If samples have no finite height, or [`Cost::Certified`] finds the field too large.
pub fn progressive_mesh(
    field: &Heightfield,
    cost: Cost,
    progress: &mut dyn FnMut(usize),
) -> Result<ProgressiveMesh, ClassicError> {
    refuse_gaps(field)?;
    let (mesh, outline) = (FaceMesh::from_heightfield(field), Outline::of(field));
    Ok(match cost {
        Cost::Certified => {
            let collapses = plain::simplify_with(field, progress)?;
            ProgressiveMesh::from_half_edge_collapses(field, &collapses.order, &collapses.parent)?
        }
        Cost::Quadric => {
            let quadrics = quadric::Quadrics::new(&mesh);
            decimated(Decimation::new(mesh, outline, quadrics), progress)
        }
        Cost::Spring => {
            let springs = spring::AnchorSprings::new(&mesh, &outline);
            decimated(Decimation::new(mesh, outline, springs), progress)
        }
    })
}

fn decimated<C: cost::CollapseCost>(mut decimation: Decimation<C>, progress: &mut dyn FnMut(usize)) -> ProgressiveMesh {
    decimation.run(progress);
    ProgressiveMesh::from_collapses(&decimation.mesh, &decimation.collapses)
}
