//! The progressive-mesh builder: from the full grid of one patch to its corners, one certified half-edge collapse at a time.
//!
//! Reading order: [`mesh`] (connectivity), [`surface`] (samples and the radial error), [`fan`] (error of the triangles that
//! would replace a star), [`border_rules`] (wakes and targets along the four sides), [`guard`] (what interior collapses
//! beside a border must leave possible), [`builder`] (the queue).

pub mod border_rules;
pub mod builder;
pub mod fan;
pub mod guard;
pub mod mesh;
pub mod state;
pub mod surface;
