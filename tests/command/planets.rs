//! Commands that take a recipe's name in place of a planet file, and keep what they build in the user's cache.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, device, text};
use std::path::{Path, PathBuf};
use std::process::Output;

/// Runs the command in a folder, with a cache there.
fn terrane(folder: &Path, arguments: &[&str]) -> Output {
    command(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder.join("cache")).output().expect("terrane runs")
}

fn succeeds(folder: &Path, arguments: &[&str]) -> Output {
    let output = terrane(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    output
}

/// The planet files in the cache.
fn kept(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder.join("cache/terrane")).into_iter().flatten().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "planet")).collect()
}

const SHOT: [&str; 8] = ["--at", "10,20,90000", "--size", "64x64", "--json", "--spacing", "4000", "--out"];

#[test]
fn a_name_is_a_planet_whose_patches_are_kept_in_the_cache() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let built = |planet: &str, out: &str| {
        let output = succeeds(folder, &[&["shot", planet], &SHOT[..], &[out]].concat());
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (summary["patches_built"].as_u64().unwrap(), text(&output.stderr))
    };
    assert!(built("tiny", "a.png").0 > 0);
    let files = kept(folder);
    assert!(files.len() == 1 && files[0].file_name().unwrap().to_string_lossy().starts_with("tiny-"), "{files:?}");
    assert_eq!(built("Tiny", "b.png"), (0, String::new()), "patches were built again");
    let recipe = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml")).unwrap();
    std::fs::write(folder.join("own.toml"), recipe.replace("seed = 7", "seed = 8")).unwrap();
    assert!(built("own.toml", "c.png").0 > 0);
    assert_eq!(kept(folder).len(), 2);
    let pictures = ["a.png", "b.png", "c.png"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(pictures[0] == pictures[1] && pictures[0] != pictures[2], "another recipe is another planet");

    // A picture names its planet.
    succeeds(folder, &["shot", "--view", "a.png", "--out", "d.png"]);
    assert!(std::fs::read(folder.join("d.png")).unwrap() == pictures[0]);

    for damage in [&b"SQLite format 3\0, but no more"[..], b""] {
        std::fs::write(&files[0], damage).unwrap();
        let (count, said) = built("tiny", "e.png");
        assert!(count > 0 && said.contains("made anew") && said.contains("tiny-"), "{said}");
        assert!(std::fs::read(folder.join("e.png")).unwrap() == pictures[0]);
    }
}

#[test]
fn an_edited_planet_in_the_cache_keeps_its_edits_and_says_so() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shot = |out: &str| {
        let said = text(&succeeds(folder, &[&["shot", "tiny"], &SHOT[..], &[out]].concat()).stderr);
        (std::fs::read(folder.join(out)).unwrap(), said)
    };
    let (original, _) = shot("a.png");
    let file = kept(folder).remove(0).display().to_string();
    succeeds(folder, &["edit", &file, "crater", "--at", "10,20", "--radius", "9000", "--depth", "2000"]);
    for out in ["b.png", "c.png"] {
        let (edited, said) = shot(out);
        assert!(edited != original && said.contains("Tiny has 1 edit of its ground") && !said.contains("not kept"), "{said}");
        assert!(said.contains(&format!("'terrane edit {file} list'")), "{said}");
    }
    assert!(edits_of(folder, &file) == 1 && kept(folder).len() == 1);
    std::fs::remove_file(&file).unwrap();
    assert_eq!(shot("d.png"), (original.clone(), String::new()));
    succeeds(folder, &["edit", &file, "raise", "--at", "10,20", "--radius", "9000", "--by", "900"]);
    succeeds(folder, &["edit", &file, "undo"]);
    assert_eq!(shot("e.png"), (original, String::new()));
}

/// How many edits a file has.
fn edits_of(folder: &Path, file: &str) -> usize {
    let listed = succeeds(folder, &["edit", file, "list", "--json"]);
    serde_json::from_slice::<serde_json::Value>(&listed.stdout).unwrap()["edits"].as_array().unwrap().len()
}

#[test]
fn a_cache_that_cannot_be_written_keeps_nothing_and_says_so() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("cache"), "in the way").unwrap();
    let output = succeeds(folder, &[&["shot", "tiny"], &SHOT[..], &["a.png"]].concat());
    assert!(text(&output.stderr).contains("what is built is not kept: cannot make the folder"), "{}", text(&output.stderr));
}

#[test]
fn meshes_of_a_name_are_of_its_coarsest_patches() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = succeeds(folder, &["mesh", "tiny", "--whole", "--json", "--out", "x.ply"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(summary["closed"] == true && summary["triangles"].as_u64().unwrap() > 1000, "{summary}");
}

#[test]
fn what_is_no_planet_is_refused_with_the_names_that_are() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["shot", "pluto", "--out", "x.png"][..],
        &["shot", "--out", "x.png"],
        &["shot", "--view", "terrane:1/planet=Pluto/at=0,0/altitude=9", "--out", "x.png"],
        &["fly", "pluto"],
        &["verify", "pluto"],
        &["bench", "pluto", "--path", "descent"],
        &["record", "pluto", "--path", "descent", "--out", "frames"],
        &["mesh", "pluto", "--out", "x.ply"],
    ] {
        let output = terrane(folder.path(), arguments);
        let message = text(&output.stderr);
        assert!(output.status.code() == Some(1) && message.contains("terra, luna, mars, tiny"), "{arguments:?}: {message}");
    }
}
