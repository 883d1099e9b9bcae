//! The geometry of a globe, before there is any ground: cube-sphere directions, the lattice of exact positions, patches and their
//! neighbours, where the sun stands; and what belongs to a patch without being part of it (random numbers, an LRU cache).

pub mod lattice;
pub mod patch;
pub(crate) mod patch_cache;
pub mod random;
pub mod sphere;
pub mod sun;
