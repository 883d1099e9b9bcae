//! Every command that writes refuses an output that cannot be, before it reads, builds or draws anything.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};

#[test]
fn an_output_without_a_folder_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    // None of the inputs exists: a message about one would mean that it was read first.
    let cases: [(&[&str], &str); 9] = [
        (&["shot", "gone.planet", "--out", "no/x.png"], "--out: cannot write no/x.png"),
        (&["record", "gone.planet", "--path", "descent", "--out", "no/x.mp4"], "--out: cannot write no/x.mp4"),
        (&["mesh", "gone.planet", "--out", "no/x.glb"], "--out: cannot write no/x.glb"),
        (&["simplify", "gone.tif", "--faces", "9", "--out", "no/x.glb"], "--out: cannot write no/x.glb"),
        (&["simplify", "gone.tif", "--faces", "9,8", "--out", "no/x.glb"], "--out: cannot write no/x-9.glb"),
        (&["bench", "gone.planet", "--path", "descent", "--json", "no/x.json"], "--json: cannot write no/x.json"),
        (&["compare", "gone.planet", "--json", "no/x.json"], "--json: cannot write no/x.json"),
        (&["growth", "gone.planet", "--plot", "no/x.svg"], "--plot: cannot write no/x.svg"),
        (&["bake", "gone.toml", "--levels", "1", "--out", "no/x.planet"], "--out: cannot write no/x.planet"),
    ];
    for (arguments, message) in cases {
        let output = terrane(arguments, folder.path());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(said.contains(message) && said.contains("its folder no does not exist; make it"), "{arguments:?}: {said}");
    }
    for arguments in [
        &["gallery", "--out", "file"][..],
        &["study", "--out", "file"],
        &["record", "gone.planet", "--path", "descent", "--out", "file"],
        &["fly", "gone.planet", "--screenshots", "file"],
    ] {
        let output = terrane(arguments, folder.path());
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(1) && said.contains("it is a file; choose a folder"), "{arguments:?}: {said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn an_output_that_can_be_leaves_the_input_to_be_missed() {
    let folder = tempfile::tempdir().unwrap();
    let output = terrane(&["mesh", "gone.planet", "--out", "x.glb"], folder.path());
    assert!(text(&output.stderr).contains("gone.planet"), "{}", text(&output.stderr));
}
