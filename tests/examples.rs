//! Every program of `examples/` runs, in an empty folder, and writes what it says.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

#[path = "common/skipped.rs"]
mod skipped;

use skipped::skipped;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrane::vulkan::{Context, ContextOptions};

/// An example: its name, whether it needs a device, and the file that it makes, if any, with the bytes that this begins with.
type Example = (&'static str, bool, Option<(&'static str, &'static [u8])>);

const EXAMPLES: [Example; 4] = [
    ("buffers", false, Some(("terrane-buffers.obj", b"v "))),
    ("heights", false, None),
    ("own_terrain", false, Some(("terrane-own.planet", b"SQLite format 3"))),
    ("picture", true, Some(("terrane-picture.png", b"\x89PNG"))),
];

/// Cargo builds examples beside the programs of the tests.
fn program(name: &str) -> PathBuf {
    let here = std::env::current_exe().unwrap();
    let program = here.ancestors().nth(2).unwrap().join("examples").join(name);
    assert!(program.exists(), "{} is not built: run `cargo build --examples`, or all tests of the package", program.display());
    program
}

/// Whether there is a device; none prints "skipped", or fails where `TERRANE_REQUIRE_GPU=1`.
fn has_device() -> bool {
    let context = Context::new(&ContextOptions::default());
    if let Err(error) = &context {
        skipped(error);
    }
    context.is_ok()
}

/// Runs a program with `folder` as its folder for temporary files.
fn run(name: &str, folder: &Path) -> String {
    let output = Command::new(program(name)).env("TMPDIR", folder).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn examples_run_and_write_what_they_say() {
    let device = has_device();
    for (name, _, made) in EXAMPLES.into_iter().filter(|(_, needs_device, _)| device || !needs_device) {
        let folder = tempfile::tempdir().unwrap();
        let said = run(name, folder.path());
        assert!(!said.is_empty(), "{name} says nothing");
        if let Some((file, head)) = made {
            assert!(said.contains(file), "{name} does not name {file}: {said}");
            assert!(std::fs::read(folder.path().join(file)).unwrap().starts_with(head), "{name}: {file}");
        }
    }
}

#[test]
fn the_heights_of_the_example_agree() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("heights", folder.path());
    let metres = |line: &str| -> f64 { line.split_whitespace().rev().find_map(|word| word.parse().ok()).unwrap() };
    let heights: Vec<f64> = said.lines().map(|line| metres(line.split(" m").next().unwrap())).collect();
    let [exact, coarse, fine, ray] = heights[..] else { panic!("{said}") };
    assert!((fine - exact).abs() < 2.0 && (ray - fine).abs() < 0.01, "{said}");
    assert!((coarse - exact).abs() > 2.0, "six faces tell nothing of the ground here: {said}");
}

#[test]
fn every_example_is_in_the_list() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut there: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    there.sort_unstable();
    assert_eq!(there, EXAMPLES.map(|(name, ..)| name));
}
