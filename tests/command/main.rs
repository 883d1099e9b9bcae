//! The command, run as a user runs it, as one program: each links everything. `fly.rs` is another: its frames must not wait for others.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

#[path = "../common/mod.rs"]
mod common;

mod bake;
mod compress;
mod edit;
mod elevation;
mod gallery;
mod georeference;
mod gltf;
mod gpu;
mod look;
mod mesh_and_bench;
mod network;
mod output;
mod planets;
mod raster;
mod record;
mod simplify;
mod study;
mod tiles;
mod views;
