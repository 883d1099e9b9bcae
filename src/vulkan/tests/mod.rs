//! The Vulkan layer on a real device, with validation: any message fails a test.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

#[path = "../../../tests/gpu/checked.rs"]
pub(crate) mod checked;
mod compute;
mod drawing;
mod images;
mod machine;
mod shaders;
mod validation;

use checked::device;
