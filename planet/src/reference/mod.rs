//! CPU twins of the GPU stages, under the same names: same inputs, same results, bit for bit.

pub mod air;
pub mod emit;
pub mod position;
pub mod resolve;
pub mod select;
pub mod tonemap;
