//! Plain heightfields: a rectangle of height samples, as elevation models come, and the triangle surfaces that approximate them.
//!
//! [`import`] reads files, [`plain`] and [`polished`] simplify with a measured error, on top of the half-edge core in [`decimate`]
//! that the patches of planets are built with too; [`classic`] has the classics under their names, for study and comparison.
//! Knows no planet.

pub mod angles;
pub mod classic;
pub mod decimate;
mod deviation;
mod field;
mod fill;
mod holes;
pub mod import;
pub mod plain;
mod polish;
pub mod polished;
mod raster;

pub use deviation::Deviation;
pub use field::{Heightfield, TriangleSurface};
pub use holes::Holes;
