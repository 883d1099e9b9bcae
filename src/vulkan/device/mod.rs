//! The device and what it comes from: instance, validation, choice of GPU, features, memory, a window's surface.

pub(super) mod choice;
pub(super) mod context;
pub(super) mod features;
pub(super) mod gpu;
pub(super) mod instance;
pub(super) mod memory;
pub(super) mod messages;
pub(super) mod surface;
