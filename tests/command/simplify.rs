//! `terrane simplify` as a process, on real elevation data.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

fn jacksboro() -> PathBuf {
    repository("planet/recipes/jacksboro_fault_dem.tif")
}

/// Runs the command on a file; its JSON.
fn simplify(file: &Path, arguments: &[&str], folder: &Path) -> Value {
    let output = terrane(&[&["simplify", file.to_str().unwrap(), "--json"], arguments].concat(), folder);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Vertices and faces of a PLY file, and the box that its vertices fill.
fn read_ply(path: &Path) -> (usize, usize, [[f64; 3]; 2]) {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = text(&bytes[..end]);
    assert!(header.contains("+X east, +Y north, +Z up"), "{header}");
    let count = |what: &str| -> usize { header.lines().find_map(|l| l.strip_prefix(what)).unwrap().trim().parse().unwrap() };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    assert_eq!(bytes.len(), end + 36 * vertices + 13 * faces);
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for point in bytes[end..end + 36 * vertices].chunks(36) {
        for k in 0..3 {
            let coordinate = f64::from_le_bytes(point[8 * k..8 * k + 8].try_into().unwrap());
            (low[k], high[k]) = (low[k].min(coordinate), high[k].max(coordinate));
        }
    }
    (vertices, faces, [low, high])
}

#[test]
fn levels_have_the_face_counts_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let result = simplify(&jacksboro(), &["--faces", "20000,2000,200", "--out", "j.ply"], folder.path());
    assert_eq!((&result["columns"], &result["rows"], &result["format"]), (&403.into(), &344.into(), &"TIFF".into()));
    assert_eq!((&result["cost"], &result["filled"]), (&"certified".into(), &0.into()));
    let spacing = [number(&result["spacing_m"][0]), number(&result["spacing_m"][1])];
    assert!((spacing[0] - 74.5).abs() < 0.2 && (spacing[1] - 92.5).abs() < 0.2, "{spacing:?}");
    assert!((number(&result["bounds_deg"]["west"]) + 84.41333).abs() < 1e-4, "{}", result["bounds_deg"]);
    let levels = result["levels"].as_array().unwrap();
    let mut before = 0.0;
    for (level, faces) in levels.iter().zip([20_000, 2000, 200]) {
        assert_eq!(level["file"], format!("j-{faces}.ply"));
        let (vertices, found, [low, high]) = read_ply(&folder.path().join(level["file"].as_str().unwrap()));
        assert_eq!((level["vertices"].as_u64().unwrap() as usize, level["faces"].as_u64().unwrap() as usize), (vertices, found));
        assert!((faces - 1..=faces).contains(&found), "{found} of {faces}");
        // The whole rectangle in metres, and heights as they are.
        assert_eq!(low[..2], [0.0, 0.0]);
        assert!((high[0] - 402.0 * spacing[0]).abs() < 1e-6 && (high[1] - 343.0 * spacing[1]).abs() < 1e-6, "{high:?}");
        let (max, rms) = (number(&level["max_error"]), number(&level["rms_error"]));
        // Polished vertices leave their samples, but by no more than the error that is measured there.
        assert!(low[2] >= 236.0 - max && high[2] <= 1076.0 + max);
        assert!(max > before && rms > 0.0 && rms < max && level["uncovered"] == 0, "{level}");
        before = max;
    }
    assert!(number(&levels[0]["max_error"]) < 20.0, "{}", levels[0]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn kept_samples_stay_and_polish_lowers_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let polished = simplify(&jacksboro(), &["--faces", "2000", "--out", "p.ply"], folder.path());
    let kept = simplify(&jacksboro(), &["--faces", "2000", "--keep-samples", "--out", "k.ply"], folder.path());
    assert_eq!((&polished["polished"], &kept["polished"]), (&true.into(), &false.into()));
    let (_, _, [low, high]) = read_ply(&folder.path().join("k.ply"));
    assert!(low[2] >= 236.0 && high[2] <= 1076.0);
    let [polished, kept] = [polished, kept].map(|result| number(&result["levels"][0]["max_error"]));
    assert!(polished < 0.85 * kept, "{polished} m polished, {kept} m on samples");
}

#[test]
fn north_is_at_the_largest_y() {
    // The first row of the file is its highest: it must come out at the largest y.
    let folder = tempfile::tempdir().unwrap();
    let samples: Vec<u8> = (0..5_u16).flat_map(|row| [(4 - row) * 100; 5]).flat_map(u16::to_le_bytes).collect();
    std::fs::write(folder.path().join("slope.raw"), samples).unwrap();
    let options = ["--faces", "2", "--spacing", "30", "--height-scale", "0.5", "--out", "slope.obj"];
    let result = simplify(Path::new("slope.raw"), &options, folder.path());
    assert_eq!((&result["levels"][0]["file"], number(&result["levels"][0]["max_error"])), (&"slope.obj".into(), 0.0));
    let text = std::fs::read_to_string(folder.path().join("slope.obj")).unwrap();
    let mut vertices: Vec<&str> = text.lines().filter(|l| l.starts_with("v ")).collect();
    vertices.sort_unstable();
    assert_eq!(vertices, ["v 0 0 0", "v 0 200 -120", "v 120 0 0", "v 120 200 -120"]);
    assert!(text.contains("+Y up, -Z north") && text.lines().filter(|l| l.starts_with("f ")).count() == 2);
}

#[test]
fn errors_are_at_most_those_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut faces = Vec::new();
    for cost in ["certified", "quadric", "spring"] {
        let options = ["--error", "20,60.5", "--cost", cost, "--spacing", "90", "--height-scale", "1", "--out", "e.glb"];
        let result = simplify(&repository("tests/data/jacksboro_257.raw"), &options, folder.path());
        assert_eq!((&result["cost"], &result["spacing_m"]), (&cost.into(), &serde_json::json!([90.0, 90.0])));
        for (level, (error, file)) in
            result["levels"].as_array().unwrap().iter().zip([(20.0, "e-e20.glb"), (60.5, "e-e60.5.glb")])
        {
            assert!(number(&level["max_error"]) <= error && number(&level["max_error"]) > 0.7 * error, "{cost}: {level}");
            assert_eq!(level["file"], file);
            let bytes = std::fs::read(folder.path().join(file)).unwrap();
            assert_eq!((&bytes[..4], level["bytes"].as_u64().unwrap() as usize), (&b"glTF"[..], bytes.len()));
            faces.push(number(&level["faces"]));
        }
    }
    assert!(faces.chunks(2).all(|f| f[0] > 2.0 * f[1]) && faces[0] < faces[2] && faces[0] < faces[4], "{faces:?}");
}

#[test]
fn gaps_are_filled_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    // 7 x 5 levels, one of which is declared as no data.
    let file = repository("fuzz/seeds/tiff/u16_deflate");
    let output = terrane(
        &["simplify", file.to_str().unwrap(), "--height-scale", "1", "--faces", "30", "--out", "t.ply", "--json"],
        folder.path(),
    );
    assert!(text(&output.stderr).contains("filled 1 of 35 samples"), "{}", text(&output.stderr));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&result["filled"], &result["levels"][0]["uncovered"]), (&1.into(), &0.into()));
    assert_eq!((&result["spacing_m"], &result["bounds_deg"]), (&serde_json::json!([1.0, 1.0]), &Value::Null));
}

#[test]
fn bad_requests_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("odd.raw"), [0; 7]).unwrap();
    let file = jacksboro();
    let file = file.to_str().unwrap();
    let cases: [(&[&str], i32, &str); 8] = [
        (&["odd.raw", "--faces", "9", "--out", "a.ply"], 1, "found 7 bytes, expected two bytes a sample of a square"),
        (&["gone.raw", "--faces", "9", "--out", "a.ply"], 1, "gone.raw: found No such file"),
        (&[file, "--faces", "9", "--out", "a.dae"], 1, "names no mesh format"),
        (&[file, "--faces", "1", "--out", "a.ply"], 1, "expected 2 or more"),
        (&[file, "--error", "nan", "--out", "a.ply"], 1, "expected 0 or more metres"),
        (&[file, "--faces", "9,9", "--out", "a.ply"], 1, "a-9.ply; ask for each level once"),
        (&[file, "--out", "a.ply"], 2, "--faces"),
        (&[file, "--faces", "9", "--out", "no/such/a.ply"], 1, "cannot write no/such/a.ply"),
    ];
    for (arguments, code, message) in cases {
        let output = terrane(&[&["simplify"], arguments].concat(), folder.path());
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        assert!(text(&output.stderr).contains(message), "{arguments:?}: {}", text(&output.stderr));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}
