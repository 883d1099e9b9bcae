//! CPU twins of the GPU stages, under the same names: same inputs, same results, bit for bit.
//!
//! [`cut`] is the one stage that runs on the CPU in production too.

pub mod cut;
pub mod emit;
pub mod place;
pub mod resolve;
pub mod select;
