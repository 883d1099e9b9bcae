//! `terrane gpus` and `terrane verify` as processes, and the message of each command where there is no driver.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, skipped, text};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::{BakedPatch, PlanetFile};

/// Whether there is a device; none prints "skipped", or fails where `TERRANE_REQUIRE_GPU=1`.
fn has_device() -> bool {
    let output = command(&["gpus"]).output().unwrap();
    let found = output.status.success() && text(&output.stdout).contains(" usable");
    if !found {
        skipped(&text(&output.stderr));
    }
    found
}

fn tiny(seed: &str) -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let recipe = std::fs::read_to_string(path).unwrap();
    assert!(recipe.contains("seed = 7\n"));
    let recipe = Recipe::from_toml(&recipe.replace("seed = 7\n", &format!("seed = {seed}\n")), "tiny", Path::new(".")).unwrap();
    Planet::from_recipe(recipe, 32).unwrap()
}

/// Bakes the tiny planet to level 1, with one patch of `other` if one is given.
fn bake_tiny(path: &Path, other: Option<(&Planet, PatchId)>) {
    let planet = tiny("7");
    let mut file = PlanetFile::create_or_resume(path, &planet.header()).unwrap();
    if let Some((other, id)) = other {
        assert_eq!(other.lattice, planet.lattice);
        let (mesh, texture, _) = other.build(id);
        file.put(&[BakedPatch::new(&mesh, &texture).unwrap()]).unwrap();
    }
    let plan = BakePlan::new(planet.recipe.radius, 1, None).unwrap();
    let summary = bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    assert_eq!(summary.skipped, usize::from(other.is_some()));
}

fn verify(path: &Path) -> (Output, Value) {
    let output = command(&["verify", "--views", "8", "--validate", "--json"]).arg(path).output().unwrap();
    let found = serde_json::from_slice(&output.stdout);
    let json = found.unwrap_or_else(|e| panic!("{e}: {} {}", text(&output.stdout), text(&output.stderr)));
    (output, json)
}

#[test]
fn a_sound_planet_is_verified() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiny.planet");
    bake_tiny(&path, None);
    let (output, json) = verify(&path);
    assert_eq!(output.status.code(), Some(0), "{json} {}", text(&output.stderr));
    for fault in ["cracks", "gpu_cpu_mismatches", "flipped", "degenerate", "closure_violations", "dropped_triangles"] {
        assert_eq!(json[fault], 0, "{fault}: {json}");
    }
    assert_eq!(json["views"], 8);
    assert!(json["triangles"].as_u64().unwrap() > 1000, "{json}");
    let (error, tolerance) = (&json["screen_error_px"], json["tolerance_px"].as_f64().unwrap());
    assert!((0.2 * tolerance..=tolerance).contains(&error["max"].as_f64().unwrap()), "{json}");
    assert!(error["p50"].as_f64() <= error["p99"].as_f64() && error["p99"].as_f64() <= error["p999"].as_f64(), "{json}");
    assert_eq!(json["screen_errors"].as_array().unwrap().len(), 4, "{json}");
    assert!(text(&output.stderr).contains("largest error at 0.5 px"), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("8/8 views"), "no progress: {}", text(&output.stderr));
}

#[test]
fn a_patch_of_another_planet_is_a_crack() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("patched.planet");
    let id = PatchId::roots().nth(2).unwrap().children().unwrap()[1];
    bake_tiny(&path, Some((&tiny("8"), id)));
    let (output, json) = verify(&path);
    assert_eq!(output.status.code(), Some(1), "{json}");
    assert!(json["cracks"].as_u64().unwrap() > 0, "{json}");
    assert_eq!(json["gpu_cpu_mismatches"], 0, "{json}");
    assert!(text(&output.stderr).contains("cracks in the surface"), "{}", text(&output.stderr));
}

#[test]
fn the_gpus_are_listed() {
    if !has_device() {
        return;
    }
    let output = command(&["gpus", "--json"]).output().unwrap();
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let first = &json["gpus"][0];
    assert_eq!((&first["index"], first["name"].is_string(), first["usable"].is_boolean()), (&0.into(), true, true), "{json}");
    assert!(first["api_version"].as_str().unwrap().starts_with("1."));
    let uuid = first["uuid"].as_str().unwrap();
    assert_eq!(uuid.split('-').map(str::len).collect::<Vec<_>>(), [8, 4, 4, 4, 12], "{uuid}");
    let said = command(&["gpus"]).output().unwrap();
    assert!(text(&said.stdout).contains(&format!("UUID {uuid}")), "{}", text(&said.stdout));
}

/// The GPU that is taken unless told otherwise.
fn usual_gpu() -> Value {
    let output = command(&["gpus", "--json"]).output().unwrap();
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let order = ["discrete", "integrated", "virtual", "cpu", "other"];
    let rank = |gpu: &&Value| order.iter().position(|kind| gpu["kind"] == *kind);
    json["gpus"].as_array().unwrap().iter().filter(|gpu| gpu["usable"] == true).min_by_key(rank).unwrap().clone()
}

#[test]
fn commands_without_a_window_say_nothing_of_what_draws() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let planet = folder.path().join("tiny.planet");
    bake_tiny(&planet, None);
    let gpu = usual_gpu();
    for chosen in [&[][..], &["--gpu", gpu["uuid"].as_str().unwrap()], &["--gpu", &gpu["index"].to_string()]] {
        let mut command = command(&["verify", "--views", "1"]);
        let output = command.args(chosen).arg(&planet).output().unwrap();
        assert!(output.status.success(), "{chosen:?}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("the software renderer"), "{}", text(&output.stderr));
    }
}

#[test]
fn the_log_tells_what_takes_how_long_to_who_asks_and_nothing_to_others() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let says = |levels: &str| {
        let arguments = ["shot", "tiny", "--at", "10,20,9000", "--size", "64x64", "--spacing", "5000", "--out"];
        let mut command = command(&arguments);
        command.arg(folder.path().join("x.png")).env("RUST_LOG", levels).env("XDG_CACHE_HOME", folder.path().join(levels));
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr).to_owned()
    };
    let trace = says("terrane=trace");
    let of_patches = ["survey{patch=", "build mesh{patch=", "relief{patch="];
    let of_frames = [
        "cut: terrane::scene: close",
        "prepare: terrane::frame: close",
        "record{zone=\"draw\"}: ",
        "wait{",
        "terrane::gpu: select ",
    ];
    for span in of_patches.iter().chain(&of_frames) {
        assert!(trace.contains(span) && trace.contains("time.busy="), "{span}: {trace}");
    }
    let debug = says("terrane=debug");
    for (spans, are_there) in [(&of_patches[..], true), (&of_frames[..], false)] {
        assert!(spans.iter().all(|span| debug.contains(span) == are_there), "{spans:?}: {debug}");
    }
    assert!(!says("warn").contains("time.busy="));
}

#[test]
fn without_a_driver_every_command_says_what_to_install() {
    let cases: [&[&str]; 3] =
        [&["gpus"], &["shot", "tiny", "--at", "0,0,1000", "--out", "x.png"], &["verify", "x.planet", "--views", "1"]];
    let folder = tempfile::tempdir().unwrap();
    for arguments in cases {
        let mut command = command(arguments);
        command.current_dir(folder.path()).env("XDG_CACHE_HOME", folder.path());
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        let output = command.output().unwrap();
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
        let named = errors.contains("no Vulkan driver was found") && errors.contains("mesa-vulkan-drivers");
        assert!(named || errors.contains("the Vulkan loader was not found"), "{arguments:?}: {errors}");
        assert!(!errors.contains("panicked") && output.stdout.is_empty(), "{arguments:?}: {errors}");
    }
}
