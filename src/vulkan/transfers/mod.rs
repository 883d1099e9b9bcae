//! Host data on its way to the device, and back: batched uploads, downloads of buffers, captures of images.

pub(super) mod capture;
pub(super) mod download;
pub(super) mod upload;
