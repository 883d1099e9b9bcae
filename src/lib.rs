//! Terrane's run time: draws the patches of a planet file with Vulkan.
//!
//! [`scene`] keeps the right patches on the GPU, [`frame`] selects, emits and draws them, [`headless`] and [`stills`] make still pictures,
//! [`verify`] compares what was drawn with the CPU twins, `app` (with the feature of that name) flies in a window, `hot_reload` (with its feature) follows shaders as they are edited, and [`vulkan`]
//! is the thin layer below, the only place with `unsafe`.

#[cfg(feature = "app")]
pub mod app;
pub mod frame;
#[cfg(feature = "hot-reload")]
mod glsl;
pub mod headless;
#[cfg(feature = "hot-reload")]
pub mod hot_reload;
pub mod measure;
pub mod scene;
pub mod shaders;
pub mod stills;
pub mod verify;
pub mod vulkan;

/// The example of the README is a test: it compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
