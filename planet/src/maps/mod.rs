//! Tables that light looks things up in: where clouds are, the grain of the ground, the slopes of waves, and mip levels of them.

pub mod clouds;
pub mod grain;
pub mod mip;
pub mod waves;
