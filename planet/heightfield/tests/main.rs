//! All tests of this folder as one program: each program links everything, and these need no process of their own.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod classic_costs;
mod classic_splits;
mod import;

#[test]
fn every_file_here_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for name in names.filter_map(|name| name.strip_suffix(".rs").map(str::to_owned)) {
        let found = name == "main" || include_str!("main.rs").contains(&format!("\nmod {name};\n"));
        assert!(found, "planet/heightfield/tests/{name}.rs is not run: add it to main.rs");
    }
}
