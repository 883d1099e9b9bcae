//! CPU twins of the GPU stages, under the same names: same inputs, same results, bit for bit.
//!
//! [`cut`] and [`work`] are the stages that run on the CPU in production too.

pub mod air;
pub mod cut;
pub mod emit;
pub mod place;
pub mod resolve;
pub mod select;
pub mod tonemap;
pub mod work;
