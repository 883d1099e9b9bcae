//! Every seed of the fuzzer goes through the function that the fuzzer calls: a fault that it once found does not return.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "../../fuzz/targets.rs"]
#[allow(missing_docs, unreachable_pub, reason = "shared with the fuzz programs")]
mod targets;

use std::path::Path;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;
use terrane_planet::store::{geometry, imagery};

/// Runs all seeds of a target.
fn run(target: &str, function: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds").join(target);
    let mut seeds: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    assert!(seeds.len() >= 3, "{} holds too few seeds", folder.display());
    for seed in seeds {
        // The output of a failed test ends with the seed that failed.
        println!("{}", seed.display());
        function(&std::fs::read(&seed).unwrap());
    }
}

#[test]
fn png_seeds_do_not_panic() {
    run("png", targets::png);
}

#[test]
fn tiff_seeds_do_not_panic() {
    run("tiff", targets::tiff);
}

#[test]
fn raw_seeds_do_not_panic() {
    run("raw", targets::raw);
}

#[test]
fn hgt_seeds_do_not_panic() {
    run("hgt", targets::hgt);
}

#[test]
fn grid_seeds_do_not_panic() {
    run("grid", targets::grid);
}

#[test]
fn archive_seeds_do_not_panic() {
    run("archive", targets::archive);
}

#[test]
fn options_seeds_do_not_panic() {
    run("options", targets::options);
}

#[test]
fn systems_seeds_do_not_panic() {
    run("systems", targets::systems);
}

#[test]
fn photo_seeds_do_not_panic() {
    run("photo", targets::photo);
}

#[test]
fn geometry_seeds_do_not_panic() {
    run("geometry", targets::geometry);
}

#[test]
fn imagery_seeds_do_not_panic() {
    run("imagery", targets::imagery);
}

#[test]
fn surroundings_seeds_do_not_panic() {
    run("surroundings", targets::surroundings);
}

/// Checksums and versions would stop old records at the door: what the seeds are for is behind it. `TERRANE_UPDATE=1` writes them anew.
#[test]
fn records_among_the_seeds_reach_the_decoders() {
    let (id, cells) = targets::patch().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds");
    for (name, recipe) in [("record0", "tiny"), ("record40", "luna"), ("record80", "mars"), ("record120", "terra")] {
        let read = |target: &str| std::fs::read(folder.join(target).join(name)).unwrap();
        if std::env::var_os("TERRANE_UPDATE").is_some() {
            let build = |cells| Planet::from_recipe(shipped::load(recipe).unwrap(), cells).unwrap().build(id);
            let write = |target: &str, record: Vec<u8>| std::fs::write(folder.join(target).join(name), record).unwrap();
            write("geometry", geometry::encode(&build(targets::GEOMETRY_CELLS).0).unwrap());
            write("imagery", imagery::encode(&build(cells).1, id, cells).unwrap());
        }
        geometry::decode(&read("geometry"), id, targets::GEOMETRY_CELLS).unwrap();
        imagery::decode(&read("imagery"), id, cells).unwrap();
    }
}
