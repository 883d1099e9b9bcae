//! `terrane fly` as a process on an X server of its own: it starts, obeys mouse and keys, survives resizing, saves pictures, and ends
//! without a message from the validation layers.

#![allow(clippy::unwrap_used, reason = "a failure fails the test")]

#[path = "../../common/mod.rs"]
mod common;

mod flights;
mod full_screen;
mod harness;
mod interface;
#[cfg(feature = "hot-reload")]
mod shaders;
