//! The command, run as a user runs it, as one program: each links everything. `fly.rs` is another: its frames must not wait for others.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

#[path = "../common/mod.rs"]
mod common;

mod bake;
mod edit;
mod gallery;
mod gpu;
mod look;
mod mesh_and_bench;
mod record;
mod simplify;
mod study;

#[test]
fn every_file_here_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/command");
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for name in names.filter_map(|name| name.strip_suffix(".rs").map(str::to_owned)) {
        let found = ["main", "fly"].contains(&name.as_str()) || include_str!("main.rs").contains(&format!("\nmod {name};\n"));
        assert!(found, "tests/command/{name}.rs is not run: add it to main.rs");
    }
}
