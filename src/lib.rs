//! Terrane's run time: draws the patches of a planet file with Vulkan.
//!
//! [`scene`] keeps the right patches on the GPU, [`frame`] selects, emits and draws them, [`headless`] makes still pictures,
//! and [`vulkan`] is the thin layer below, the only place with `unsafe`.

pub mod frame;
pub mod headless;
pub mod measure;
pub mod scene;
pub mod shaders;
pub mod vulkan;
