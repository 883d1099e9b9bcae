//! All tests of this folder as one program: each program links everything, and these need no process of their own.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;
#[path = "common/whole_planet.rs"]
mod whole_planet;

mod bake;
mod builder;
mod chunks;
mod edited_ground;
mod edits;
mod export;
mod export_maps;
mod export_read_back;
mod extremes;
mod fuzz_seeds;
mod heightmaps;
mod horizon;
mod imagery;
mod in_sight;
mod independence;
mod kept_by_a_file;
mod motion;
mod partial_patches;
mod positions;
mod precision;
mod published;
mod queries;
mod recipes;
mod rooms;
mod screen_error;
mod store;
mod terrain;
mod tiles;
mod watertight;
mod work;
