//! The files of `data/dem` against GDAL's own reading: heights sample by sample, and places. Where GDAL is not installed heights
//! stay unchecked here, which is said, and places are checked against those that it gave when they were recorded.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use terrane_heightfield::import::{load, Imported};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/dem").join(name)
}

fn gdal_is_there() -> bool {
    let there = ["gdal_translate", "gdaltransform"].iter().all(|tool| Command::new(tool).arg("--version").output().is_ok());
    if !there {
        eprintln!("skipped: no gdal_translate and gdaltransform here (Debian: gdal-bin)");
    }
    there
}

/// Files, and longitude and latitude of their north-western and south-eastern samples, as GDAL 3.6 gave them.
const PLACES: [(&str, [f64; 4]); 11] = [
    ("utm.tif", [9.0000657103, 46.9534842081, 9.0125493485, 46.9478142500]),
    ("cog.tif", [9.0000657103, 46.9534842081, 9.0125493485, 46.9478142500]),
    ("big.tif", [9.0000657103, 46.9534842081, 9.0125493485, 46.9478142500]),
    ("d4326.tif", [10.0001388889, 46.0087500000, 10.0265277778, 45.9912500000]),
    ("d4269.tif", [10.0001388889, 46.0087500000, 10.0265277778, 45.9912500000]),
    ("d4258.tif", [10.0001388889, 46.0087500000, 10.0265277778, 45.9912500000]),
    ("ftus.tif", [-78.9999832217, 35.3985942489, -78.9967954204, 35.3968632294]),
    ("merc.tif", [8.9831977570, 60.0014153112, 8.9917317522, 59.9985856181]),
    ("southup.tif", [9.0000657103, 46.9534842081, 9.0125493485, 46.9478142500]),
    ("moon.tif", [10.0050000000, 0.9950000000, 10.9550000000, 0.3650000000]),
    ("mars.tif", [0.0000843530, 0.0053142405, 0.0161114276, -0.0053142405]),
];

/// Heights as GDAL reads them, scale and offset included; its rows run as the file's.
fn of_gdal(name: &str, folder: &Path) -> Vec<f64> {
    let out = folder.join("out.img");
    let run = Command::new("gdal_translate")
        .args(["-q", "-of", "ENVI", "-ot", "Float64", "-unscale"])
        .args([file(name), out.clone()])
        .stderr(Stdio::inherit())
        .status();
    assert!(run.unwrap().success(), "{name}");
    std::fs::read(&out).unwrap().chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

/// The first sample that differs.
fn difference(image: &Imported, theirs: &[f64]) -> Option<String> {
    let ours = image.field.heights();
    assert_eq!(ours.len(), theirs.len());
    // What no file declares they keep as a number, and we do not.
    let is_gap = |h: f64| h.is_nan() || h == -9999.0 || h < -1e30;
    let same = |ours: f32, theirs: f64| if ours.is_nan() { is_gap(theirs) } else { f64::from(ours) == f64::from(theirs as f32) };
    let at = ours.iter().zip(theirs).position(|(&ours, &theirs)| !same(ours, theirs))?;
    Some(format!("sample {at} is {}, theirs {}", ours[at], theirs[at]))
}

#[test]
fn heights_agree_with_gdals_reading_sample_by_sample() {
    if !gdal_is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let names = [
        "utm.tif",
        "cog.tif",
        "big.tif",
        "d4326.tif",
        "d4269.tif",
        "ftus.tif",
        "merc.tif",
        "southup.tif",
        "sparse_d.tif",
        "sparse_r.tif",
        "f64.tif",
        "i32.tif",
        "zstd.tif",
        "nan0.tif",
        "nan1.tif",
        "nd.tif",
        "nd0.tif",
        "ndmax.tif",
        "so.tif",
        "moon.tif",
        "mars.tif",
        "a.asc",
    ];
    for name in names {
        let image = load(&file(name)).unwrap();
        let mut theirs = of_gdal(name, folder.path());
        if name == "southup.tif" {
            theirs = theirs.chunks_exact(96).rev().flatten().copied().collect();
        }
        assert_eq!(difference(&image, &theirs), None, "{name}");
        theirs[777] += 0.01;
        assert!(difference(&image, &theirs).is_some(), "the check sees a centimetre");
    }
}

/// Whether places agree to a part in a hundred of a sample.
fn is_there(image: &Imported, [west, north, east, south]: [f64; 4]) -> bool {
    let place = image.georeference.as_ref().unwrap();
    let [first, .., last] = place.corners_deg;
    let metre = 1.0 / place.body.radian_m(north)[1].to_radians();
    [(first, [west, north]), (last, [east, south])]
        .iter()
        .all(|(found, wanted)| (0..2).all(|k| (found[k] - wanted[k]).abs() < 0.1 * metre))
}

#[test]
fn places_agree_with_gdals_reading() {
    for (name, recorded) in PLACES {
        let image = load(&file(name)).unwrap();
        assert!(is_there(&image, recorded), "{name}: {:?}, recorded {recorded:?}", image.georeference);
        assert!(!is_there(&image, recorded.map(|degrees| degrees + 1e-5)), "{name}: the check sees a metre");
    }
    if !gdal_is_there() {
        return;
    }
    for (name, recorded) in PLACES {
        let system = match name {
            "moon.tif" => "+proj=longlat +R=1737400",
            "mars.tif" => "+proj=longlat +R=3396190",
            _ => "EPSG:4326",
        };
        let mut tool = Command::new("gdaltransform");
        let tool = tool.args(["-t_srs", system]).arg(file(name)).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut run = tool.spawn().unwrap();
        // Centres of the first and of the last sample; files with the south up count rows from there.
        let rows = if name == "southup.tif" { [63.5, 0.5] } else { [0.5, 63.5] };
        writeln!(run.stdin.take().unwrap(), "0.5 {}\n95.5 {}", rows[0], rows[1]).unwrap();
        let output = run.wait_with_output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let numbers: Vec<f64> =
            text.lines().flat_map(|line| line.split_whitespace().take(2)).map(|n| n.parse().unwrap()).collect();
        for (found, recorded) in numbers.iter().zip(recorded) {
            assert!((found - recorded).abs() < 1e-8, "{name}: {numbers:?}");
        }
    }
}
