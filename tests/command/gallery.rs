//! `terrane gallery` as a process: small JPEGs, a page with the commands that drew them, and a list that is checked.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{device, terrane, text};
use std::path::Path;

/// A list of two pictures of the tiny planet.
fn list(folder: &Path, second: &str) {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let entry = |name: &str, at: &str| {
        let recipe = recipe.display();
        format!("[[picture]]\nname = '{name}'\nrecipe = '{recipe}'\nlevels = 0\noptions = '--stored-only --at {at}'\ncaption = 'Tiny at {at}'\n")
    };
    std::fs::write(folder.join("list.toml"), entry("afar", "10,20,60000") + &entry(second, "10,20,9000")).unwrap();
}

const GALLERY: [&str; 8] = ["gallery", "--list", "list.toml", "--out", "pages", "--size", "96x64", "--json"];

#[test]
fn the_page_shows_what_was_drawn_and_the_commands_that_drew_it() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    list(folder.path(), "near");
    let page = || std::fs::read_to_string(folder.path().join("pages/README.md")).unwrap();
    let output = terrane(&[&GALLERY[..], &["--only", "near"]].concat(), folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(page().contains("near.jpg") && !page().contains("afar.jpg"), "{}", page());
    let output = terrane(&[&GALLERY[..], &["--only", "afar"]].concat(), folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    for part in [
        "![Tiny at 10,20,60000](afar.jpg)",
        "near.jpg",
        "terrane bake ",
        "terrane shot out/tiny.planet --stored-only --at 10,20,9000 --size 96x64 --ssaa 2 --out out/near.png",
    ] {
        assert!(page().contains(part), "{part}: {}", page());
    }
    for name in ["near", "afar"] {
        let bytes = std::fs::read(folder.path().join(format!("pages/{name}.jpg"))).unwrap();
        assert!(bytes.starts_with(&[0xff, 0xd8]) && (500..400_000).contains(&bytes.len()), "{name}: {} bytes", bytes.len());
    }
}

#[test]
fn the_list_of_the_documentation_comes_with_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let output = terrane(&["gallery", "--only", "nowhere"], folder.path());
    assert!(text(&output.stderr).contains("gallery.toml has no picture called nowhere"), "{}", text(&output.stderr));
    assert_eq!((output.status.code(), std::fs::read_dir(folder.path()).unwrap().count()), (Some(1), 0));
}

#[test]
fn a_list_with_a_mistake_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    list(folder.path(), "afar");
    let fails = |more: &[&str], part: &str| {
        let output = terrane(&[&GALLERY[..], more].concat(), folder.path());
        assert!(!output.status.success() && text(&output.stderr).contains(part), "{part}: {}", text(&output.stderr));
    };
    fails(&[], "two pictures are called afar");
    list(folder.path(), "../near");
    fails(&[], "'../near' is no name");
    list(folder.path(), "near");
    fails(&["--only", "far"], "no picture called far");
    std::fs::write(folder.path().join("list.toml"), "[[picture]]\nname = 'a'\n").unwrap();
    fails(&[], "list.toml: not a list of pictures");
}
