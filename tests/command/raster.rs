//! `terrane height` and `terrane raster` as processes: their numbers against the terrain's own, read back by our reader and by GDAL.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, terrane, text};
use crate::mesh_and_bench::planet_in;
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use terrane_heightfield::import::photo;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::ground::GroundPoint;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;

fn json(arguments: &[&str], folder: &std::path::Path) -> Value {
    let output = terrane(arguments, folder);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn heights_of_sites_are_those_of_the_terrain_with_their_slopes() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 16).unwrap();
    for (file, stored) in [("tiny.planet", true), ("tiny", false)] {
        let found = json(&["height", file, "--at", "12.5,-33", "--spacing", "10", "--json"], folder.path());
        assert_eq!(number(&found["height_m"]), planet.terrain.height(direction_at(12.5, -33.0)));
        let step = 10.0 / planet.recipe.radius * 180.0 / std::f64::consts::PI;
        let at = |north: f64, east: f64| {
            planet.terrain.height(direction_at(12.5 + north * step, -33.0 + east * step / 12.5_f64.to_radians().cos()))
        };
        let wanted = [-(at(0.0, 1.0) - at(0.0, -1.0)) / 20.0, -(at(1.0, 0.0) - at(-1.0, 0.0)) / 20.0];
        let normal: Vec<f64> = found["normal"].as_array().unwrap().iter().map(number).collect();
        assert!((normal[0] / normal[2] - wanted[0]).abs() < 0.02 && (normal[1] / normal[2] - wanted[1]).abs() < 0.02, "{found}");
        // Patches of level 2 have 4 × 16 cells over a quarter of the equator.
        let spacing = 0.25 * 2.0 * std::f64::consts::PI * planet.recipe.radius / 64.0;
        match stored {
            true => assert!((number(&found["stored_spacing_m"]) / spacing - 1.0).abs() < 0.3, "{found}"),
            false => assert_eq!(found["stored_spacing_m"], Value::Null),
        }
    }
    let output = terrane(&["height", "tiny", "--at", "95,0"], folder.path());
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("expected -90 to 90 degrees"));
}

#[test]
fn rasters_hold_the_terrain_where_their_keys_say() {
    let folder = tempfile::tempdir().unwrap();
    let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 64).unwrap();
    let base = ["raster", "tiny", "--at", "40,-20", "--size", "31x21", "--spacing", "100", "--json"];
    let summary = json(&[&base[..], &["--out", "h.tif"]].concat(), folder.path());
    let bounds = |name: &str| number(&summary["bounds_deg"][name]);
    let image = terrane_heightfield::import::load(&folder.path().join("h.tif")).unwrap();
    assert_eq!((image.field.columns(), image.field.rows()), (31, 21));
    let site = |column: usize, row: usize| {
        let along = column as f64 / 30.0;
        let down = row as f64 / 20.0;
        [bounds("north") + down * (bounds("south") - bounds("north")), bounds("west") + along * (bounds("east") - bounds("west"))]
    };
    let height = |[latitude, longitude]: [f64; 2]| planet.terrain.height(direction_at(latitude, longitude));
    for (column, row) in [(0, 0), (30, 0), (0, 20), (30, 20), (15, 10)] {
        let (found, wanted) = (f64::from(image.field.at(column, row)), height(site(column, row)));
        assert!((found - wanted).abs() < 1e-3, "{column}, {row}: {found} m, expected {wanted} m");
    }
    assert!((image.field.at(0, 0) - image.field.at(30, 20)).abs() > 1.0, "flat ground tells nothing");
    let middle = site(15, 10);
    assert!((middle[0] - 40.0).abs() < 1e-9 && (middle[1] + 20.0).abs() < 1e-9);
    let across = (bounds("north") - bounds("south")).to_radians() * planet.recipe.radius;
    assert!((across - 2000.0).abs() < 1e-6, "{across} m");
    read_by_gdal(folder.path(), planet.recipe.radius, &|latitude, longitude| height([latitude, longitude]));
    let colours = json(&[&base[..], &["--albedo", "--out", "a.tif"]].concat(), folder.path());
    assert_eq!(colours["holds"], "albedo");
}

#[test]
fn rasters_of_albedo_hold_the_terrains_own_colours() {
    let folder = tempfile::tempdir().unwrap();
    let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 64).unwrap();
    let spacing = 150.0;
    let base =
        ["raster", "tiny", "--at", "40,-20", "--size", "31x21", "--spacing", "150", "--albedo", "--out", "a.tif", "--json"];
    let summary = json(&base, folder.path());
    let bounds = |name: &str| number(&summary["bounds_deg"][name]);
    let picture = photo::read(&std::fs::read(folder.path().join("a.tif")).unwrap(), "a.tif").unwrap();
    assert_eq!(picture.size(), [31, 21]);
    let step = [(bounds("east") - bounds("west")) / 30.0, (bounds("north") - bounds("south")) / 20.0];
    let site = |column: f64, row: f64| direction_at(bounds("north") - row * step[1], bounds("west") + column * step[0]);
    // The ground at a sample from its neighbours, and its colour from the terrain.
    let colour = |column: usize, row: usize| {
        let (x, y) = (column as f64, row as f64);
        let height = |x: f64, y: f64| planet.terrain.height(site(x, y));
        let metres = planet.recipe.radius * step.map(f64::to_radians)[0] * site(x, y).truncate().length();
        let east = (height(x + 1.0, y) - height(x - 1.0, y)) / (2.0 * metres);
        let north = (height(x, y - 1.0) - height(x, y + 1.0)) / (2.0 * spacing);
        let point = GroundPoint { direction: site(x, y), height: height(x, y), slope: east.hypot(north), north, spacing };
        let mut found = [[0; 3]];
        planet.terrain.albedo(&[point], &mut found);
        found[0]
    };
    let mut seen = std::collections::HashSet::new();
    for (column, row) in (0..31).flat_map(|column| (0..21).map(move |row| (column, row))) {
        let (found, wanted) = (picture.pixels[row * 31 + column], colour(column, row));
        assert!((0..3).all(|k| found[k].abs_diff(wanted[k]) <= 1), "{column}, {row}: {found:?}, expected {wanted:?}");
        seen.insert(wanted);
    }
    assert!(seen.len() > 20, "{} colours tell little", seen.len());
    let shifted = (0..30).filter(|&column| picture.pixels[10 * 31 + column] != colour(column + 1, 10)).count();
    assert!(shifted > 20, "the check sees a shift by a sample");
}

/// Whether a process has said what it does on SIGINT.
#[cfg(target_os = "linux")]
fn listens(process: u32) -> bool {
    const SIGINT: u64 = 1 << 1;
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & SIGINT != 0)
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_raster_leaves_no_file() {
    for what in [&[][..], &["--albedo"]] {
        let folder = tempfile::tempdir().unwrap();
        let arguments = ["raster", "tiny", "--at", "0,0", "--size", "10000x10000", "--spacing", "1", "--out", "x.tif"];
        let mut child = command(&[&arguments[..], what].concat());
        let child = child.current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        while !listens(child.id()) {
            assert!(begun.elapsed() < Duration::from_secs(60), "it never listens for signals");
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("interrupted, nothing written"), "{}", text(&output.stderr));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "something is left behind");
    }
}

/// GDAL's own reading of the same file: the sphere, and a height at a place.
fn read_by_gdal(folder: &std::path::Path, radius: f64, height: &dyn Fn(f64, f64) -> f64) {
    let gdal = |program: &str, arguments: &[&str]| Command::new(program).args(arguments).current_dir(folder).output();
    let Ok(info) = gdal("gdalinfo", &["-json", "h.tif"]) else {
        println!("skipped: gdal-bin is not installed, so that no other reader looks at the raster");
        return;
    };
    let info: Value = serde_json::from_slice(&info.stdout).unwrap();
    let wkt = info["coordinateSystem"]["wkt"].as_str().unwrap();
    assert!(wkt.contains(&format!("{radius}")) && wkt.contains("GEOG"), "{wkt}");
    assert_eq!(info["bands"][0]["type"], "Float32");
    let transform: Vec<f64> = info["geoTransform"].as_array().unwrap().iter().map(number).collect();
    // GDAL's transform counts from the corner of the first pixel, half a pixel off its sample.
    let [longitude, latitude] = [transform[0] + 3.5 * transform[1], transform[3] + 7.5 * transform[5]];
    let read = gdal("gdallocationinfo", &["-valonly", "h.tif", "3", "7"]).unwrap();
    let found: f64 = text(&read.stdout).trim().parse().unwrap();
    let wanted = height(latitude, longitude);
    assert!((found - wanted).abs() < 0.01, "{found} m, expected {wanted} m");
    assert!((found - height(latitude + transform[5], longitude)).abs() > 0.01, "the check sees a shift by a sample");
}

#[test]
fn rasters_that_cannot_be_are_refused_with_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    for (at, size, spacing, out, message) in [
        ("90,0", "10x10", "100", "x.tif", "farther from the pole"),
        ("0,0", "1x10", "100", "x.tif", "expected sides of 2 or more"),
        ("0,0", "100000x100000", "1", "x.tif", "ask for fewer"),
        ("0,0", "10x10", "100", "x.png", "expected .tif or .tiff"),
        ("0,0", "10x10", "0", "x.tif", "expected 0.001 to 1000000 metres"),
    ] {
        let output = terrane(&["raster", "tiny", "--at", at, "--size", size, "--spacing", spacing, "--out", out], folder.path());
        assert!(output.status.code() == Some(1) && text(&output.stderr).contains(message), "{at}: {}", text(&output.stderr));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}
