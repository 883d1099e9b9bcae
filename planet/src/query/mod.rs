//! Where the ground is: heights and rays against the finest patches that are known, in f64, without a GPU.
//!
//! In: the sample grids of patches, as they come and go. Out: heights over directions and hits of rays, each with the spacing
//! of the samples it is exact to. What is known anywhere is what the finest drawn surface shows there: the full grid of a patch
//! whose siblings are known too. [`Refiner`] makes finer patches known in the background.

mod known_ground;
mod patch_grid;
mod raycast;
pub mod rays;
mod refiner;

pub use known_ground::{GroundHeight, KnownGround};
pub use patch_grid::PatchGrid;
pub use raycast::GroundHit;
pub use refiner::{Refinement, Refiner};
