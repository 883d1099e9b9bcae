//! The progressive-mesh builder: from the full grid of one patch to its corners, one certified half-edge collapse at a time.
//!
//! Reading order: [`mesh`] (connectivity), [`samples`] (what is approximated), [`star`] (a vertex's neighbourhood and the ranking of
//! its collapses), [`fan`] (the exact measure of one), `sweep` (the same while the vertex slides), [`decimator`] (the four together). On top of that stand two simplifiers:
//! [`plain`] for heightfields, by rising error ([`polished`] then moves its vertices to where the error is largest); and [`builder`] for patches, by rising wake, with [`surface`] (the gnomonic plane and
//! the radial error), [`border_rules`] (wakes and targets along the four sides) and [`guard`] (what interior collapses beside a
//! border must leave possible).

pub mod border_rules;
pub mod builder;
mod crossings;
pub mod decimator;
pub mod fan;
pub mod guard;
mod lanes;
pub mod mesh;
pub mod plain;
pub mod polished;
mod queue;
pub mod samples;
pub mod star;
pub mod surface;
mod sweep;
