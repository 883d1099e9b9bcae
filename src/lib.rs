//! placeholder

pub mod shaders;
pub mod vulkan;
