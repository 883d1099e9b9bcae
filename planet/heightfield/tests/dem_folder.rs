//! The files of `data/dem`, which GDAL 3.6 wrote, come out as `expected.json` there says: extent, heights and where the peak is; or
//! are refused with the way out.

use serde_json::Value;
use std::path::{Path, PathBuf};
use terrane_heightfield::import::{load, load_with, Encoding, Imported, Options};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/dem")
}

/// Files that are refused as they are, with what the message says; and with what they are read, if with anything.
fn refused(file: &str) -> Option<(&'static str, Option<Options>)> {
    let encoding = |encoding| Some(Options { encoding: Some(encoding), ..Options::default() });
    let sized = Some(Options { raw_size: Some([96, 64]), ..Options::default() });
    match file {
        "lerc.tif" => Some(("gdal_translate -co COMPRESS=ZSTD", None)),
        "rot.tif" => Some(("gdalwarp", None)),
        "terrarium.png" => Some(("--encoding terrarium", encoding(Encoding::Terrarium))),
        "mapbox.png" => Some(("--encoding terrarium or mapbox", encoding(Encoding::Mapbox))),
        "w.r16" | "w.r32" => Some(("--raw-size", sized)),
        _ => None,
    }
}

fn read(file: &str, options: &Options) -> Result<Imported, String> {
    let image = load_with(&folder().join(file), options).map_err(|e| e.to_string())?;
    image.unplaced.as_ref().map_or(Ok(()), |e| Err(e.to_string()))?;
    Ok(image)
}

/// Whether an image is what is expected, to a part in 400 of lengths: they were made with rounder numbers.
fn fault(image: &Imported, expected: &Value) -> Option<String> {
    let pair = |key: &str| expected[key].as_array().map(|pair| [pair[0].as_f64().unwrap(), pair[1].as_f64().unwrap()]);
    let size = [image.field.columns(), image.field.rows()];
    if let Some(wanted) = pair("extent_m") {
        let Some(spacing) = image.spacing_m else { return Some("no spacing".into()) };
        let found = [0, 1].map(|k| spacing[k] * (size[k] - 1) as f64);
        if (0..2).any(|k| (found[k] / wanted[k] - 1.0).abs() > 2.6e-3) {
            return Some(format!("{found:?} m, expected {wanted:?}"));
        }
    }
    if let Some(wanted) = pair("heights_m") {
        let off = (0..2).map(|k| (f64::from(image.range[k]) - wanted[k]).abs()).fold(0.0, f64::max);
        // Whole metres, halves, and the steps of colours.
        let most = match expected["file"].as_str() {
            Some("i32.tif") => 1.0,
            Some("mapbox.png") => 0.051,
            _ => 0.0051,
        };
        if off > most {
            return Some(format!("heights {:?}, expected {wanted:?}", image.range));
        }
    }
    let highest = image.field.heights().iter().position(|&h| h == image.range[1])?;
    let east = highest % size[0] >= size[0] / 2;
    let north = highest / size[0] < size[1] / 2;
    let peak = format!("{}{}", if north { "n" } else { "s" }, if east { "e" } else { "w" });
    expected["peak"].as_str().filter(|&wanted| wanted != peak).map(|wanted| format!("the peak is {peak}, expected {wanted}"))
}

#[test]
fn files_of_other_programs_come_out_as_expected() {
    let text = std::fs::read_to_string(folder().join("expected.json")).unwrap();
    let all: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(all.len(), 30);
    for expected in &all {
        let file = expected["file"].as_str().unwrap();
        let options = match refused(file) {
            None => Some(Options::default()),
            Some((words, options)) => {
                let message = read(file, &Options::default()).expect_err(file);
                assert!(message.contains(words), "{file}: {message}");
                options
            }
        };
        let Some(options) = options else { continue };
        let image = read(file, &options).unwrap();
        assert_eq!(fault(&image, expected), None, "{file}");
        // The check sees another extent, other heights and another peak.
        if !expected["heights_m"].is_null() {
            let mut other = image.clone();
            other.range[1] += 2.0;
            assert!(fault(&other, expected).is_some(), "{file}");
        }
        if let (Some(spacing), false) = (image.spacing_m, expected["extent_m"].is_null()) {
            let other = Imported { spacing_m: Some([1.01 * spacing[0], spacing[1]]), ..image.clone() };
            assert!(fault(&other, expected).is_some(), "{file}");
        }
    }
}

#[test]
fn gaps_of_all_kinds_are_the_same_samples() {
    let gaps = |name: &str| -> Vec<usize> {
        let image = load(&folder().join(name)).unwrap();
        image.field.heights().iter().enumerate().filter(|(_, h)| h.is_nan()).map(|(i, _)| i).collect()
    };
    let declared = gaps("nd.tif");
    assert_eq!(declared.len(), 150);
    for name in ["nan0.tif", "nan1.tif", "nd0.tif", "ndmax.tif"] {
        assert_eq!(gaps(name), declared, "{name}");
    }
}
