//! The progressive mesh of a patch, and how it is built: from the full grid to the patch's corners, one certified half-edge collapse
//! at a time, by rising wake.
//!
//! Reading order: [`wake`] and [`certificate`] (what is promised), [`border`] (canonical wakes and targets of border lines),
//! [`surface`] (the gnomonic plane and the radial error), [`border_rules`], [`guard`] (what interior collapses beside a border must leave
//! possible), [`builder`], [`progressive`] (the finished mesh), [`survey`] (a patch before it is built), [`build_patch`] (all of it for one
//! patch).

pub mod border;
pub mod border_rules;
mod build_patch;
pub mod builder;
pub mod certificate;
pub mod guard;
pub mod progressive;
pub mod surface;
pub mod survey;
pub mod wake;

pub use build_patch::build_patch;
