//! `terrane height` and `terrane raster` as processes: their numbers against the terrain's own, read back by our reader and by GDAL.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use crate::mesh_and_bench::planet_in;
use serde_json::Value;
use std::process::Command;
use terrane_planet::globe::sphere::direction_at;
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
