//! All tests of this folder as one program: each program links everything, and these need no process of their own.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;
#[path = "common/whole_planet.rs"]
mod whole_planet;

mod bake;
mod builder;
mod edited_ground;
mod edits;
mod export;
mod extremes;
mod fuzz_seeds;
mod heightmaps;
mod horizon;
mod independence;
mod motion;
mod positions;
mod precision;
mod queries;
mod recipes;
mod rooms;
mod screen_error;
mod store;
mod terrain;
mod watertight;
mod work;

#[test]
fn every_file_here_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for name in names.filter_map(|name| name.strip_suffix(".rs").map(str::to_owned)) {
        let found = name == "main" || include_str!("main.rs").contains(&format!("\nmod {name};\n"));
        assert!(found, "planet/tests/{name}.rs is not run: add it to main.rs");
    }
}
