//! Half-edge collapses: the core that the simplifier of heightfields and the builder of patches share.
//!
//! Reading order: [`mesh`] (connectivity), [`samples`] (what is approximated), [`star`] (a vertex's neighbourhood and the ranking of
//! its collapses), [`fan`] (the exact measure of one), [`sweep`] (the same while the vertex slides), [`decimator`] (the four
//! together), [`queue`].

mod crossings;
pub mod decimator;
pub mod fan;
pub mod lanes;
pub mod mesh;
pub mod queue;
pub mod samples;
pub mod star;
pub mod sweep;
