//! `terrane mesh`, `terrane bench` and `terrane compare` as processes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, device, skipped, terrane, text};
use std::path::{Path, PathBuf};
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::PlanetFile;

/// Bakes a small planet into a folder.
pub(crate) fn planet_in(folder: &Path) -> PathBuf {
    let recipe = Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml")).unwrap();
    let planet = Planet::from_recipe(recipe, 16).unwrap();
    let out = folder.join("tiny.planet");
    let mut file = PlanetFile::create_or_resume(&out, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, 2, None).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &false.into()).unwrap();
    out
}

fn json(bytes: &[u8]) -> serde_json::Value {
    serde_json::from_slice(bytes).unwrap_or_else(|e| panic!("{e}: {}", text(bytes)))
}

#[test]
fn meshes_are_written_whole_and_described() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let mut triangles = Vec::new();
    for (name, whole) in [("a.obj", true), ("a.ply", true), ("a.glb", true), ("a.3mf", true), ("view.glb", false)] {
        let mut arguments = vec!["mesh", "tiny.planet", "--at", "10,20,500", "--look", "30,-20", "--out", name, "--json"];
        arguments.extend(whole.then_some("--whole"));
        let output = terrane(&arguments, folder.path());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let summary = json(&output.stdout);
        assert_eq!((&summary["closed"], &summary["mesh"]), (&whole.into(), &name.into()));
        assert_eq!(summary["bytes"], std::fs::metadata(folder.path().join(name)).unwrap().len());
        assert!(summary["largest_coordinate_m"].as_f64().unwrap() < 70_000.0);
        triangles.push(summary["triangles"].as_u64().unwrap());
    }
    assert!(triangles[0] > 1000 && triangles[..4].iter().all(|t| *t == triangles[0]), "{triangles:?}");
    assert!((50..triangles[0]).contains(&triangles[4]), "{triangles:?}");
}

#[test]
fn meshes_have_the_triangles_that_the_device_draws() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let mut more_with_geomorphs = false;
    for at in ["10,20,20000", "10,20,500", "-35,100,20"] {
        let view = ["tiny.planet", "--at", at, "--look", "30,-45", "--size", "320x180", "--json", "--out"];
        let triangles = |command: &str, more: &[&str]| {
            let output = terrane(&[&[command], &view[..], more].concat(), folder.path());
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            json(&output.stdout)["triangles"].as_u64().unwrap()
        };
        let (exported, drawn) = (triangles("mesh", &["a.ply"]), triangles("shot", &["a.png", "--stored-only", "--no-geomorphs"]));
        assert!(exported == drawn && drawn > 0, "{at}: {exported} exported, {drawn} drawn");
        more_with_geomorphs |= triangles("shot", &["a.png", "--stored-only"]) > drawn;
    }
    assert!(more_with_geomorphs, "the option did nothing");
}

#[test]
fn failed_meshes_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    std::fs::create_dir(folder.path().join("folder.obj")).unwrap();
    let cases = [
        ("a.dae", "-20", "expected .glb, .obj, .ply, .stl or .3mf"),
        ("a.stl", "-20", "add --solid"),
        ("no/such/a.obj", "-20", "cannot write no/such/a.obj"),
        ("folder.obj", "-20", "cannot write folder.obj"),
        ("a.obj", "60", "draws no triangle"),
    ];
    for (out, pitch, message) in cases {
        let output =
            terrane(&["mesh", "tiny.planet", "--at", "0,95,500", "--look", &format!("0,{pitch}"), "--out", out], folder.path());
        assert_eq!(output.status.code(), Some(1), "{out}");
        assert!(text(&output.stderr).contains(message), "{out}: {}", text(&output.stderr));
    }
    let mut left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["folder.obj", "tiny.planet"]);
}

#[test]
fn benches_record_every_frame() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let arguments =
        ["bench", "tiny.planet", "--path", "descent", "--frames", "3", "--warmup", "1", "--size", "160x90", "--json", "b.json"];
    let output = terrane(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("gpu wall ms"));
    let result = json(&std::fs::read(folder.path().join("b.json")).unwrap());
    let rows = result["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    let number = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
    assert!(number(0, "triangles") > 0.0 && number(2, "triangles") > 0.0 && number(1, "frame_ms") > 0.0, "{rows:?}");
    assert!((number(0, "altitude_m") / 93_000.0 - 1.0).abs() < 1e-9 && number(2, "time_s") == 60.0);
    assert!(!result["commit"].as_str().unwrap().is_empty() && !result["device"].as_str().unwrap().is_empty());
    assert_eq!(result["summary"]["frame ms"]["frames"], 3);
}

#[test]
fn first_looks_build_once_and_turns_find_ground() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let planet = planet_in(folder.path());
    let bytes = std::fs::read(&planet).unwrap();
    let view = ["--at", "10,20,2000", "--look", "30,-30", "--size", "160x90", "--spacing", "200"];
    let arguments =
        [&["bench", "tiny.planet", "--first-look", "--source-delay", "5ms,2MB/s", "--json", "f.json"], &view[..]].concat();
    let output = terrane(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("| 10,20,2000 | from the file |"), "{}", text(&output.stdout));
    let result = json(&std::fs::read(folder.path().join("f.json")).unwrap());
    let rows = result["rows"].as_array().unwrap();
    let kinds: Vec<&str> = rows.iter().map(|row| row["row"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["from nothing", "from the file", "over the line", "turn"]);
    let [nothing, file, line, turn] = [0, 1, 2, 3].map(|row| &rows[row]);
    assert!(nothing["patches_built"].as_u64().unwrap() > 0 && file["patches_built"] == 0, "{rows:?}");
    assert!(nothing["patches"].as_u64().unwrap() > 0 && nothing["triangles"].as_u64().unwrap() > 0, "{rows:?}");
    assert_eq!(line["patches_built"], 0, "{rows:?}");
    for same in ["patches", "triangles"] {
        assert!(nothing[same] == file[same] && nothing[same] == line[same], "{rows:?}");
    }
    let ms = |row: &serde_json::Value, name: &str| row[name].as_f64().unwrap();
    assert!([nothing, file, line]
        .iter()
        .all(|row| 0.0 < ms(row, "first_picture_ms") && ms(row, "first_picture_ms") <= ms(row, "settled_ms")));
    assert_eq!((&turn["surrounded"], &turn["holes"], &turn["cracks"]), (&true.into(), &0.into(), &0.into()), "{turn}");
    assert_eq!(std::fs::read(&planet).unwrap(), bytes, "the given file was changed");
}

#[test]
fn first_looks_want_patches_built_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    for options in [&["--stored-only"][..], &["--cache", "0"]] {
        let output = terrane(&[&["bench", "tiny.planet", "--first-look"], options].concat(), folder.path());
        assert_eq!(output.status.code(), Some(1));
        assert!(text(&output.stderr).contains("leave out --stored-only"), "{}", text(&output.stderr));
    }
}

#[test]
fn bad_paths_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    std::fs::write(folder.path().join("bad.json"), "[{\"time_s\": 0}]").unwrap();
    for (path, message) in [("ascent", "built-in paths: descent"), ("bad.json", "missing field `latitude`")] {
        let output = terrane(&["bench", "tiny.planet", "--path", path], folder.path());
        assert_eq!(output.status.code(), Some(1), "{path}");
        assert!(text(&output.stderr).contains(message), "{path}: {}", text(&output.stderr));
    }
}

#[test]
fn comparisons_bring_every_method_to_the_same_error() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let key = |time: u32, altitude: u32, pitch: i32| {
        format!("{{\"time_s\":{time},\"latitude\":10,\"longitude\":20,\"altitude_m\":{altitude},\"heading\":30,\"pitch\":{pitch},\"fov\":50}}")
    };
    std::fs::write(folder.path().join("p.json"), format!("[{},{}]", key(0, 30_000, -90), key(9, 3000, -20))).unwrap();
    let arguments = ["compare", "tiny.planet", "--path", "p.json", "--frames", "2", "--size", "1280x720", "--json", "c.json"];
    let output = terrane(&[&arguments[..], &["--pixels", "500", "--block", "2"]].concat(), folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let result = json(&std::fs::read(folder.path().join("c.json")).unwrap());
    let rows = result["rows"].as_array().unwrap();
    let methods: Vec<&str> = rows.iter().step_by(2).map(|row| row["method"].as_str().unwrap()).collect();
    assert_eq!((methods, rows.len()), (vec!["ours", "ours", "ours", "CDLOD", "RTIN", "clusters"], 12));
    for row in rows {
        let equal = if row["equal"] == "max" { "max_px" } else { "p999_px" };
        let error = row[equal].as_f64().unwrap();
        assert!((0.5..=1.03).contains(&error) && row["missed"] == 0, "{row}");
        let mean = row["triangles_in_view"].as_f64().unwrap();
        let by_frame: Vec<f64> = row["in_view_by_frame"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect();
        assert!(mean > 50.0 && (by_frame[0] + by_frame[1]) / 2.0 == mean, "{row}");
        assert!(text(&output.stdout).contains(row["variant"].as_str().unwrap()));
    }
    assert_eq!(rows[0]["ours_over_this"], 1.0);
}

/// Mesa's software renderer keeps each shader that it compiles in its cache: a frame that compiles anew leaves something there.
#[test]
fn no_frame_compiles_a_shader_that_an_earlier_frame_had() {
    let Some(device) = device() else { return };
    if !device.contains("llvmpipe") {
        return skipped(&format!("{device} has no cache that could be counted"));
    }
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let keyframe = |time: u32, altitude: f64| {
        format!(
            r#"{{"time_s": {time}, "latitude": 10, "longitude": 20, "altitude_m": {altitude}, "heading": 30, "pitch": -10, "fov": 50}}"#
        )
    };
    std::fs::write(folder.path().join("climb.json"), format!("[{}, {}]", keyframe(0, 900.0), keyframe(10, 1100.0))).unwrap();
    let compiled = |frames: &str| {
        let cache = folder.path().join(format!("shaders of {frames}"));
        let arguments = ["bench", "tiny.planet", "--path", "climb.json", "--size", "64x48", "--frames", frames];
        let output = command(&arguments).current_dir(folder.path()).env("MESA_SHADER_CACHE_DIR", &cache).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        files_in(&cache)
    };
    let (two, eight) = (compiled("2"), compiled("8"));
    assert!(two > 10, "no cache: {two} files");
    // Six frames that compile what conditions depend on leave sixty.
    assert!(eight < two + 6, "{two} files after two frames, {eight} after eight");
}

fn files_in(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).map(|entries| entries.filter_map(Result::ok).collect::<Vec<_>>()).unwrap_or_default();
    entries.iter().map(|entry| if entry.path().is_dir() { files_in(&entry.path()) } else { 1 }).sum()
}
