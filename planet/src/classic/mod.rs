//! The classics of progressive meshes under their own names: a triangle mesh with face adjacency, edge collapses and vertex
//! splits, a progressive mesh that goes both ways (Hoppe 1996), and costs that choose what to collapse first. In: plain
//! heightfields. Out: progressive meshes to study, to compare with and to learn from; planets are built by
//! [`crate::simplify`].

mod error;
mod mesh;
mod outline;
mod progressive_mesh;
mod split;
mod validate;

use error::refuse_gaps;
pub use error::ClassicError;
pub use mesh::{grid_faces, FaceMesh, Star, NONE};
pub use progressive_mesh::ProgressiveMesh;
pub use split::{Refusal, VertexSplit};
pub use validate::{euler_characteristic, Violation};
