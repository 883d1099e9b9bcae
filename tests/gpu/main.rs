//! The stages on a real device, with validation and synchronization validation: any message fails a test.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

mod air;
mod checked;
mod clouds;
mod edges;
mod exposure;
mod extremes;
mod ground_edits;
mod harness;
mod history;
mod layout;
mod on_demand;
mod overflow;
mod slow_source;
mod stills;
mod textures;
mod twins;
mod upscale;

// Where `checked` looks for it, here and in the unit tests of the layer.
use terrane::vulkan;
