//! What commands read and write: buffers, images and samplers.

pub(super) mod buffer;
pub(super) mod image;
pub(super) mod sampler;
