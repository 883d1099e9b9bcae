//! Planets as per-patch progressive meshes: cube-sphere terrain, the progressive-mesh builder, the planet file and the
//! CPU reference of everything the GPU does. Knows no Vulkan, no window and no GPU (DESIGN: invariant 7).

pub mod recipe;
pub mod terrain;
