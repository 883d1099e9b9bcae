//! `terrane simplify` on elevation files of many kinds, as users run it: what comes out has its extent, heights and place; what is
//! assumed is said; what is not understood is refused.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use serde_json::{json, Value};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn dem(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/heightfield/tests/data/dem").join(name);
    path.to_str().unwrap().to_owned()
}

/// Runs the command; its JSON and what it said.
fn simplify(files: &[&str], arguments: &[&str], folder: &Path) -> (Value, String) {
    let output = terrane(&[&["simplify"], files, &["--json", "--out", "a.obj", "--faces", "2000"], arguments].concat(), folder);
    assert_eq!(output.status.code(), Some(0), "{files:?}: {}", text(&output.stderr));
    (serde_json::from_slice(&output.stdout).unwrap(), text(&output.stderr).to_owned())
}

fn refused(arguments: &[&str], folder: &Path) -> String {
    let output = terrane(&[&["simplify", "--out", "a.obj", "--faces", "2000"], arguments].concat(), folder);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stderr).to_owned()
}

/// Vertices and faces of an OBJ file.
fn read_obj(path: &Path) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let text = std::fs::read_to_string(path).unwrap();
    let words = |start: &'static str| text.lines().filter_map(move |line| line.strip_prefix(start));
    let three = |line: &str| -> [f64; 3] {
        let numbers: Vec<f64> = line.split_whitespace().map(|w| w.split('/').next().unwrap().parse().unwrap()).collect();
        numbers[..3].try_into().unwrap()
    };
    // The file is Y-up: east, up, south.
    let turned = |[x, y, z]: [f64; 3]| [x, -z, y];
    (words("v ").map(|line| turned(three(line))).collect(), words("f ").map(|line| three(line).map(|v| v as usize - 1)).collect())
}

/// Extent of the vertices east, north and up.
fn extent(path: &Path) -> [f64; 3] {
    let (points, _) = read_obj(path);
    [0, 1, 2].map(|k| {
        let (low, high) = points.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        high - low
    })
}

fn near(found: f64, wanted: f64, off: f64) {
    assert!((found - wanted).abs() <= off, "{found}, expected {wanted}");
}

/// A GeoTIFF of doubles in degrees of NAD 83: 60 × 40 samples, 1/1200 degree apart, west of 84.4° west; heights of a plane.
fn doubles() -> Vec<u8> {
    let value = |i: usize| 300.0 + (i % 60) as f64 * 2.0 + (39 - i / 60) as f64;
    let data: Vec<u8> = (0..2400).flat_map(|i| value(i).to_le_bytes()).collect();
    let step = 1.0_f64 / 1200.0;
    let doubles = |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let keys: Vec<u8> =
        [1_u16, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4269].iter().flat_map(|n| n.to_le_bytes()).collect();
    let long = [doubles(&[step, step, 0.0]), doubles(&[0.0, 0.0, 0.0, -84.4, 36.7, 0.0]), keys];
    let at = |k: usize| 8 + data.len() as u32 + long[..k].iter().map(|v| v.len() as u32).sum::<u32>();
    let entries: [(u16, u16, u32, u32); 12] = [
        (256, 4, 1, 60),
        (257, 4, 1, 40),
        (258, 3, 1, 64),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, 8),
        (278, 4, 1, 40),
        (279, 4, 1, data.len() as u32),
        (339, 3, 1, 3),
        (33_550, 12, 3, at(0)),
        (33_922, 12, 6, at(1)),
        (34_735, 3, 16, at(2)),
    ];
    let mut file = [b"II*\0".as_slice(), &at(3).to_le_bytes(), &data, &long.concat()].concat();
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        file.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
    }
    file.extend([0; 4]);
    file
}

#[test]
fn doubles_in_degrees_of_nad_83_have_their_extent_heights_and_place() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.tif"), doubles()).unwrap();
    let (result, said) = simplify(&["a.tif"], &["--keep-samples"], folder.path());
    assert_eq!(
        (&result["crs"], &result["unit"], &result["spacing_from"]),
        (&"EPSG:4269".into(), &"degree".into(), &"file".into())
    );
    assert!(said.contains("EPSG:4269, in units of 1 degree; 74.48"), "{said}");
    near(result["bounds_deg"]["west"].as_f64().unwrap(), -84.4 + 0.5 / 1200.0, 1e-9);
    near(result["bounds_deg"]["north"].as_f64().unwrap(), 36.7 - 0.5 / 1200.0, 1e-9);
    // A degree at latitude 36.68: 89,379 m of longitude, 110,972 m of latitude.
    let [east, north, up] = extent(&folder.path().join("a.obj"));
    near(east, 59.0 / 1200.0 * 89_379.0, 1.0);
    near(north, 39.0 / 1200.0 * 110_972.0, 1.0);
    assert_eq!(up, 59.0 * 2.0 + 39.0);
}

#[test]
fn neighbouring_srtm_tiles_become_one_mesh() {
    let folder = tempfile::tempdir().unwrap();
    // A ridge along the border that both have in common.
    for (name, west) in [("N36W085.hgt", 0_usize), ("N36W084.hgt", 1200)] {
        let height = |i: usize| (500 - (west + i % 1201).abs_diff(1200) / 4) as i16;
        let bytes: Vec<u8> = (0..1201 * 1201).flat_map(|i| height(i).to_be_bytes()).collect();
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let (result, _) = simplify(&["N36W085.hgt", "N36W084.hgt"], &["--keep-samples"], folder.path());
    assert_eq!((&result["columns"], &result["rows"], &result["gaps"]), (&2401.into(), &1201.into(), &0.into()));
    assert_eq!((result["bounds_deg"]["west"].as_f64(), result["bounds_deg"]["north"].as_f64()), (Some(-85.0), Some(37.0)));
    let [east, north, up] = extent(&folder.path().join("a.obj"));
    near(east, 2.0 * 89_591.0, 10.0);
    near(north, 110_968.0, 10.0);
    assert_eq!(up, 300.0);
    let message = refused(&["N36W085.hgt", &dem("utm.tif")], folder.path());
    assert!(message.contains("utm.tif: found EPSG:32632, expected EPSG:4326, as in the first file"), "{message}");
}

#[test]
fn a_lunar_map_in_degrees_has_the_moons_lengths() {
    let folder = tempfile::tempdir().unwrap();
    let (result, _) = simplify(&[&dem("moon.tif")], &["--keep-samples"], folder.path());
    assert_eq!((&result["radius_m"], &result["crs"]), (&1_737_400.0.into(), &"+proj=longlat +R=1737400".into()));
    let degree = 1_737_400.0_f64.to_radians();
    let [east, north, _] = extent(&folder.path().join("a.obj"));
    near(east, 0.95 * degree * 0.68_f64.to_radians().cos(), 0.5);
    near(north, 0.63 * degree, 0.5);
    near(result["bounds_deg"]["west"].as_f64().unwrap(), 10.005, 1e-9);
}

#[test]
fn what_is_assumed_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let (result, said) = simplify(&[&dem("nd0.tif")], &[], folder.path());
    assert_eq!(
        (&result["gaps"], &result["no_data"], &result["origin"]),
        (&150.into(), &Value::Null, &json!([500_005.0, 5_199_995.0]))
    );
    assert!(said.contains("150 samples of -9999") && result["notes"][0].as_str().unwrap().contains("taken as gaps"), "{said}");
    let (result, said) = simplify(&[&dem("rot.tif")], &["--spacing", "10"], folder.path());
    assert_eq!((&result["spacing_from"], &result["crs"]), (&"--spacing".into(), &Value::Null), "{said}");
    let (result, _) = simplify(&[&dem("p16.png")], &["--range", "-10,100", "--spacing", "5"], folder.path());
    assert_eq!((&result["range"], &result["spacing_m"]), (&json!([-10.0, 100.0]), &json!([5.0, 5.0])));
    let (result, said) = simplify(&[&dem("w.r16")], &["--range", "0,65535", "--raw-size", "96x64"], folder.path());
    assert_eq!((&result["columns"], &result["rows"]), (&96.into(), &64.into()));
    assert!(said.contains("states no spacing: 1 m"), "{said}");
    let (result, _) = simplify(&[&dem("utm.tif")], &["--window", "10,20,30,40"], folder.path());
    assert_eq!(result["origin"], json!([500_105.0, 5_199_795.0]));
}

#[test]
fn what_is_not_understood_is_refused_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let (p16, utm, rgb, r16, rot, asc) =
        (dem("p16.png"), dem("utm.tif"), dem("mapbox.png"), dem("w.r16"), dem("rot.tif"), dem("a.asc"));
    let cases: [(&[&str], &str); 10] = [
        (&[&p16], "--range LOW,HIGH"),
        (&[&rgb], "--encoding terrarium or mapbox"),
        (&[&r16], "--raw-size"),
        (&[&rot], "--spacing"),
        (&[&utm, "--range", "0,1"], "found --range for TIFF in metres"),
        (&[&p16, "--range", "5,1"], "the lower first"),
        (&[&utm, "--crs", "EPSG:1"], "--crs: EPSG:1"),
        (&[&utm, "--overview", "1"], "found 0 overviews"),
        (&[&asc, "--window", "0,0,5,5"], "found a window of a ASCII grid"),
        (&[&utm, "--gaps", "cut", "--cost", "spring"], "expected certified"),
    ];
    for (arguments, words) in cases {
        let message = refused(arguments, folder.path());
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
}

#[test]
fn gaps_can_be_cut_out() {
    let folder = tempfile::tempdir().unwrap();
    let area = |name: &str| {
        let (points, faces) = read_obj(&folder.path().join(name));
        let flat = |f: &[usize; 3]| {
            let [a, b, c] = f.map(|v| points[v]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        faces.iter().map(flat).sum::<f64>()
    };
    let (filled, _) = simplify(&[&dem("nd.tif")], &[], folder.path());
    near(area("a.obj"), 950.0 * 630.0, 1e-3);
    assert_eq!((&filled["filled"], &filled["polished"]), (&150.into(), &true.into()));
    let (cut, said) = simplify(&[&dem("nd.tif")], &["--gaps", "cut"], folder.path());
    assert_eq!((&cut["filled"], &cut["gaps"], &cut["polished"]), (&0.into(), &150.into(), &false.into()));
    assert!(said.contains("150 of 6144 samples hold no data, and become holes"), "{said}");
    // 15 × 10 samples, and a triangle or two of each cell around them.
    let hole = 950.0 * 630.0 - area("a.obj");
    assert!((15_000.0..17_700.0).contains(&hole), "{hole} m²");
}

#[test]
fn pipes_work() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_terrane"))
            .args(["simplify", "-", "--faces", "100", "--out", "-"])
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // A command that refuses its options reads nothing.
        let _ = child.stdin.take().unwrap().write_all(&std::fs::read(PathBuf::from(dem("utm.tif"))).unwrap());
        child.wait_with_output().unwrap()
    };
    let output = run(&["--format", "obj"]);
    let mesh = text(&output.stdout);
    assert!(output.status.success() && mesh.lines().filter(|l| l.starts_with("f ")).count() > 90, "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("triangles"), "{}", text(&output.stderr));
    for (arguments, words) in [
        (&[][..], "found no --format"),
        (&["--format", "obj", "--json"], "found --json"),
        (&["--format", "xyz"], "names no mesh format"),
    ] {
        let output = run(arguments);
        assert!(!output.status.success() && text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_raster_larger_than_memory_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    // 100,000 × 100,000 samples in one strip.
    let mut file = doubles();
    for (tag, number) in [(256_u16, 100_000_u32), (257, 100_000), (278, 100_000)] {
        let entry = file.windows(4).rposition(|w| w[..2] == tag.to_le_bytes() && w[2..] == [4, 0]).unwrap();
        file[entry + 8..entry + 12].copy_from_slice(&number.to_le_bytes());
    }
    std::fs::write(folder.path().join("huge.tif"), file).unwrap();
    let begun = std::time::Instant::now();
    let message = refused(&["huge.tif"], folder.path());
    assert!(begun.elapsed().as_secs_f64() < 1.0, "{:?}", begun.elapsed());
    for words in ["100000 x 100000 samples, which take", "GB", "--window", "--overview"] {
        assert!(message.contains(words), "{message}");
    }
}
