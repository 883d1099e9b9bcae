//! `terrane bake` and `terrane info` as processes: exit codes, messages, and the bytes of a bake that was killed and resumed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{command, text};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::store::{PlanetFile, FORMAT_VERSION};

fn recipe() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml")
}

fn bake(out: &Path, more: &[&str]) -> Command {
    let mut command = command(&["bake"]);
    command.arg(recipe()).arg("--out").arg(out).args(more);
    command
}

fn run(mut command: Command) -> Output {
    command.output().expect("terrane runs")
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {} {}", text(&output.stdout), text(&output.stderr)))
}

fn records(path: &Path) -> Vec<(PatchId, Vec<u8>, Vec<u8>)> {
    let file = PlanetFile::open(path).unwrap();
    let record = |id| (id, file.geometry_record(id).unwrap(), file.texture_record(id).unwrap());
    file.index().unwrap().into_iter().map(|r| record(r.id)).collect()
}

/// Waits until some patches are stored, while the bake still runs.
fn wait_for_patches(path: &Path, child: &mut Child) -> usize {
    let start = Instant::now();
    loop {
        let count = PlanetFile::open(path).and_then(|f| f.index()).map_or(0, |index| index.len());
        if count > 0 {
            return count;
        }
        assert!(child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(120), "nothing stored in time");
        std::thread::sleep(Duration::from_millis(2));
    }
}

const SLOW: [&str; 5] = ["--levels", "2", "--cells", "32", "--json"];

#[test]
fn a_killed_bake_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, killed] = ["whole.planet", "killed.planet"].map(|name| folder.path().join(name));
    let output = run({
        let mut command = bake(&whole, &SLOW);
        command.args(["--threads", "1"]);
        command
    });
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(json(&output)["built"], 126);
    let mut child = bake(&killed, &SLOW).args(["--threads", "2"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for_patches(&killed, &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = records(&killed).len();
    assert!(kept > 0 && kept < 126, "{kept} patches: the kill came too early or too late");
    let output = run(bake(&killed, &SLOW));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary = json(&output);
    assert_eq!((&summary["skipped"], &summary["built"]), (&kept.into(), &(126 - kept).into()));
    let expected = records(&whole);
    assert!(records(&killed) == expected, "bytes differ after a kill");
    let other = folder.path().join("other.planet");
    assert_eq!(run(bake(&other, &["--levels", "2", "--cells", "16"])).status.code(), Some(0));
    assert!(records(&other) != expected, "the comparison sees nothing");
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_keeps_its_patches_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.planet");
    let mut child = bake(&out, &SLOW).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    wait_for_patches(&out, &mut child);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let summary = json(&output);
    assert_eq!(summary["interrupted"], true);
    assert_eq!(summary["built"], records(&out).len());
}

#[test]
fn info_describes_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.planet");
    let output = run(bake(&out, &["--levels", "1", "--cells", "8", "--region", "-10,-20,0.5", "--to-level", "3"]));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output = run(command(&["info", "--json", &out.to_string_lossy()]));
    let info = json(&output);
    assert_eq!((&info["name"], &info["cells"], &info["format_version"]), (&"Tiny".into(), &8.into(), &FORMAT_VERSION.into()));
    assert_eq!(info["levels"][1]["patches"], 24);
    assert_eq!(info["levels"].as_array().unwrap().len(), 4);
    assert_eq!(info["regions"][0]["to_level"], 3);
    let output = run(command(&["info", &out.to_string_lossy()]));
    assert!(text(&output.stdout).contains("level  1: 24 of 24 patches"), "{}", text(&output.stdout));
}

#[test]
fn shipped_recipes_are_baked_by_name_from_any_folder() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let named = |name: &str| {
        let out = at(&format!("{name}.planet"));
        let mut command = command(&["bake", name, "--levels", "0", "--cells", "8", "--out", out.to_str().unwrap()]);
        command.current_dir(folder.path());
        let output = run(command);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
        PlanetFile::open(&out).unwrap().header().clone()
    };
    for name in ["terra", "luna", "mars", "tiny", "jacksboro"] {
        let header = named(name);
        assert_eq!((header.name.to_lowercase(), header.assets.len()), (name.to_owned(), usize::from(name == "jacksboro")));
    }
    let output = run(bake(&at("of the file.planet"), &["--levels", "0", "--cells", "8"]));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(records(&at("tiny.planet")) == records(&at("of the file.planet")), "not the bytes of the recipe's file");
    // A file of a shipped name is that file.
    std::fs::write(at("luna"), std::fs::read(recipe()).unwrap()).unwrap();
    std::fs::remove_file(at("luna.planet")).unwrap();
    assert_eq!(named("luna").name, "Tiny");
}

#[test]
fn failures_say_what_and_where_and_exit_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("notes.planet"), "some notes\n").unwrap();
    std::fs::write(at("bad.toml"), "name = \"x\"\nradius_m = -3\n").unwrap();
    let level = ["--levels", "0", "--cells", "8"];
    let cases = [
        (["bake", "no-such-recipe.toml", "--out", "x.planet"], "no-such-recipe.toml"),
        (
            ["bake", "nosuch", "--out", "x.planet"],
            "no recipe nosuch (shipped recipes: terra, luna, mars, tiny, jacksboro, earth)",
        ),
        (["bake", "bad.toml", "--out", "x.planet"], "radius_m"),
        (["bake", "RECIPE", "--out", "no/such/folder/x.planet"], "cannot write no/such/folder/x.planet"),
        (["bake", "RECIPE", "--out", "notes.planet"], "found a text file"),
        (["bake", "RECIPE", "--out", "."], "it is a folder; name a file in it"),
    ];
    let tiny = recipe().canonicalize().unwrap();
    for (arguments, message) in cases {
        let mut command = command(&arguments.map(|a| if a == "RECIPE" { tiny.to_str().unwrap() } else { a }));
        command.args(level).current_dir(folder.path());
        let output = run(command);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains(message), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty());
    }
    assert!(!at("x.planet").exists());
    for more in [["--levels", "1", "--cells", "17"], ["--levels", "30", "--cells", "8"], ["--levels", "13", "--cells", "8"]] {
        let output = run(bake(&at("y.planet"), &more));
        assert_eq!(output.status.code(), Some(1), "{more:?}");
        assert!(
            text(&output.stderr).contains("expected") || text(&output.stderr).contains("more than"),
            "{}",
            text(&output.stderr)
        );
    }
    assert!(!at("y.planet").exists());
}

#[test]
fn wrong_usage_exits_with_two_and_names_the_argument() {
    let cases: [(&[&str], &str); 11] = [
        (&[], "Usage"),
        (&["fly-me"], "fly-me"),
        (&["bake"], "RECIPE"),
        (&["bake", "r.toml", "--out", "x"], "--levels"),
        (&["bake", "r.toml", "--levels", "1"], "--out"),
        (&["bake", "r.toml", "--out", "x", "--levels", "many"], "many"),
        (&["bake", "r.toml", "--out", "x", "--levels", "1", "--region", "1,2,3"], "--to-level"),
        (&["bake", "r.toml", "--out", "x", "--levels", "1", "--region", "1,2", "--to-level", "3"], "three numbers"),
        (&["bake", "r.toml", "--out", "x", "--levels", "1", "--region", "91,2,1", "--to-level", "3"], "latitude 91"),
        (&["bake", "r.toml", "--out", "x", "--levels", "1", "--threads", "0"], "--threads"),
        (&["info"], "FILE"),
    ];
    for (arguments, message) in cases {
        let output = run(command(arguments));
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(message), "{arguments:?}: {}", text(&output.stderr));
    }
}
