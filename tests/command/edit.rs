//! `terrane edit` as a process: its messages, the bytes of the edited file, and the requests that it refuses.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, text};
use std::path::{Path, PathBuf};
use std::process::Output;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::store::PlanetFile;

const GRID: [&str; 4] = ["--levels", "2", "--cells", "8"];

fn recipe() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml").display().to_string()
}

fn bake(recipe: &str, out: &Path, grid: &[&str]) -> Output {
    command(&["bake", recipe, "--out", &out.to_string_lossy()]).args(grid).output().unwrap()
}

fn baked(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let output = bake(&recipe(), &path, &GRID);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    path
}

fn edit(file: &Path, arguments: &[&str]) -> Output {
    command(&["edit", &file.to_string_lossy()]).args(arguments).output().unwrap()
}

/// The object that an edit prints.
fn edited(file: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = edit(file, &[arguments, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output.stdout)))
}

type Record = (PatchId, Vec<u8>, Vec<u8>);

fn records(path: &Path) -> Vec<Record> {
    let file = PlanetFile::open(path).unwrap();
    let record = |id| (id, file.geometry_record(id).unwrap(), file.texture_record(id).unwrap());
    file.index().unwrap().into_iter().map(|r| record(r.id)).collect()
}

const CRATER: [&str; 7] = ["crater", "--at", "-10,-20", "--radius", "900", "--depth", "200"];

#[test]
fn edits_are_listed_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let file = baked(folder.path(), "a.planet");
    let (before, header) = (records(&file), PlanetFile::open(&file).unwrap().header().clone());
    let made = edited(&file, &CRATER);
    assert_eq!((&made["edit"]["kind"], &made["edit"]["depth_m"]), (&"crater".into(), &200.0.into()));
    assert_eq!((&made["edits"], &made["pending"]), (&1.into(), &0.into()));
    assert!(made["patches_rebuilt"] == made["patches_touched"] && made["patches_rebuilt"].as_u64().unwrap() >= 3, "{made}");
    let crater = records(&file);
    assert_ne!(crater, before);
    let flat = edited(&file, &["flatten", "--at=5,190", "--radius", "700"]);
    assert_eq!((&flat["edit"]["longitude_deg"], &flat["edits"]), (&(-170.0).into(), &2.into()));
    assert!(flat["edit"]["height_m"].as_f64().unwrap().abs() < 3000.0);
    edited(&file, &["raise", "--at=5,-170", "--radius", "700", "--by", "-30"]);
    let list = text(&edit(&file, &["list"]).stdout);
    assert!(list.starts_with("1: crater at -10, -20, radius 900 m") && list.contains("3: raise"), "{list}");
    let info = text(&command(&["info", &file.to_string_lossy()]).output().unwrap().stdout);
    assert!(info.contains("edit: flatten at 5, -170"), "{info}");
    assert_eq!(edited(&file, &["undo"])["edit"]["by_m"], -30.0);
    assert_eq!(edited(&file, &["undo"])["edit"]["kind"], "flatten");
    assert!(records(&file) == crater, "two edits undone leave another ground");
    let undone = text(&edit(&file, &["undo"]).stdout);
    assert!(undone.contains("undone: crater at -10, -20"), "{undone}");
    assert!(records(&file) == before, "undone, but not the bytes of before");
    assert_eq!(*PlanetFile::open(&file).unwrap().header(), header);
    let output = edit(&file, &["undo"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("there is no edit to undo"), "{}", text(&output.stderr));
}

#[test]
fn an_edited_file_is_baked_deeper_only_from_its_own_recipe() {
    let folder = tempfile::tempdir().unwrap();
    let file = baked(folder.path(), "a.planet");
    edited(&file, &CRATER);
    let before = std::fs::read(&file).unwrap();
    let deeper = ["--levels", "3", "--cells", "8"];
    let output = bake(&recipe(), &file, &deeper);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("its ground was edited"), "{}", text(&output.stderr));
    assert!(std::fs::read(&file).unwrap() == before);
    let output = bake(&file.to_string_lossy(), &file, &deeper);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let edited_recipe = folder.path().join("edited.toml");
    std::fs::write(&edited_recipe, &PlanetFile::open(&file).unwrap().header().recipe).unwrap();
    let fresh = folder.path().join("fresh.planet");
    assert_eq!(bake(&edited_recipe.to_string_lossy(), &fresh, &deeper).status.code(), Some(0));
    assert!(records(&fresh) == records(&file), "baked deeper, an edited file differs from its recipe");
}

#[test]
fn an_interrupted_edit_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let [file, whole] = ["a.planet", "b.planet"].map(|name| baked(folder.path(), name));
    edited(&whole, &CRATER);
    {
        use terrane_planet::planet::edits::add;
        use terrane_planet::planet::Planet;
        use terrane_planet::recipe::Recipe;
        let mut open = PlanetFile::open_to_edit(&file).unwrap();
        let planet = Planet::from_header(open.header()).unwrap();
        let text = &PlanetFile::open(&whole).unwrap().header().recipe.clone();
        let edit = Recipe::from_parts(text, "whole", Vec::new()).unwrap().edits[0];
        add(&mut open, &planet, edit).unwrap();
    }
    let left = records(&whole).len() - records(&file).len();
    assert!(left > 0);
    let said = text(&edit(&file, &["list"]).stdout);
    assert!(said.contains(&format!("unfinished: {left} patches")) && said.contains("resume"), "{said}");
    let info = text(&command(&["info", &file.to_string_lossy()]).output().unwrap().stdout);
    assert!(info.contains(&format!("unfinished: {left} patches")), "{info}");
    let resumed = edited(&file, &["resume"]);
    assert_eq!((&resumed["patches_rebuilt"], &resumed["edit"]), (&left.into(), &serde_json::Value::Null));
    assert!(records(&file) == records(&whole));
    assert_eq!(edited(&file, &["resume"])["patches_rebuilt"], 0);
}

#[test]
fn bad_edits_change_nothing_and_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let file = baked(folder.path(), "a.planet");
    let before = std::fs::read(&file).unwrap();
    let crater = |at, radius, depth| vec!["crater", "--at", at, "--radius", radius, "--depth", depth];
    let cases = [
        (crater("0,0", "0", "5"), 1, "`radius_m`: found 0, expected a number from 0.1 to 10000"),
        (crater("0,0", "NaN", "5"), 1, "`radius_m`: found NaN"),
        (crater("0,0", "20000", "5"), 1, "`radius_m`: found 20000"),
        (crater("0,0", "10", "inf"), 1, "`depth_m`: found inf"),
        (crater("91,0", "10", "5"), 1, "`latitude_deg`: found 91"),
        (crater("0,400", "10", "5"), 1, "`longitude_deg`: found 400"),
        (crater("0,0", "10", "99999"), 1, "make it less deep or high"),
        (crater("0,nan", "10", "5"), 2, "--at"),
        (crater("0", "10", "5"), 2, "2 numbers"),
        (vec!["dome", "--at", "0,0", "--radius", "10"], 2, "dome"),
        (vec!["flatten", "--at", "0,0", "--radius", "nan"], 1, "`radius_m`: found NaN"),
        (vec!["raise", "--at", "0,0", "--radius", "10"], 2, "--by"),
        (vec!["undo"], 1, "no edit to undo"),
    ];
    for (arguments, code, message) in cases {
        let output = edit(&file, &arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(message) && output.stdout.is_empty(), "{arguments:?}: {said}");
        assert!(std::fs::read(&file).unwrap() == before, "{arguments:?} changed the file");
    }
}

#[test]
fn files_that_cannot_be_edited_stay_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let file = baked(folder.path(), "a.planet");
    let before = std::fs::read(&file).unwrap();
    let mut permissions = std::fs::metadata(&file).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&file, permissions).unwrap();
    let output = edit(&file, &CRATER);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("the file is read-only"), "{}", text(&output.stderr));
    assert!(std::fs::read(&file).unwrap() == before);
    let notes = folder.path().join("notes.planet");
    std::fs::write(&notes, "some notes\n").unwrap();
    let missing = folder.path().join("missing.planet");
    for (path, message) in [(&notes, "found a text file"), (&missing, "cannot read the planet file")] {
        let output = edit(path, &CRATER);
        assert_eq!(output.status.code(), Some(1));
        assert!(text(&output.stderr).contains(message), "{}", text(&output.stderr));
    }
    assert!(std::fs::read(&notes).unwrap() == b"some notes\n" && !missing.exists());
}
