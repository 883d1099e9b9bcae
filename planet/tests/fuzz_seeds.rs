//! Every seed of the fuzzer goes through the function that the fuzzer calls: what it once found stays found.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "../../fuzz/targets.rs"]
#[allow(missing_docs, unreachable_pub, reason = "shared with the fuzz programs")]
mod targets;

use std::path::Path;

/// Runs all seeds of a target.
fn run(target: &str, function: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds").join(target);
    let mut seeds: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    assert!(seeds.len() >= 3, "{} holds too few seeds", folder.display());
    for seed in seeds {
        // Shown with the panic of a seed that fails.
        println!("{}", seed.display());
        function(&std::fs::read(&seed).unwrap());
    }
}

#[test]
fn a_png_seed_panics() {
    run("png", targets::png);
}

#[test]
fn a_tiff_seed_panics() {
    run("tiff", targets::tiff);
}

#[test]
fn a_raw_seed_panics() {
    run("raw", targets::raw);
}

#[test]
fn an_hgt_seed_panics() {
    run("hgt", targets::hgt);
}

#[test]
fn a_geometry_seed_panics() {
    run("geometry", targets::geometry);
}

#[test]
fn an_imagery_seed_panics() {
    run("imagery", targets::imagery);
}
