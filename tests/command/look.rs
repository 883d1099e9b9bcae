//! The light of `terrane shot`'s pictures: by date, by exposure, with clouds and without.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{device, terrane, text};
use std::path::Path;

/// A tiny planet under clouds, baked to its coarsest level.
fn planet(folder: &Path) {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let recipe = std::fs::read_to_string(recipe).unwrap() + "\n[clouds]\nheight_m = 1500.0\ncover = 0.6\n";
    std::fs::write(folder.join("cloudy.toml"), recipe).unwrap();
    let output = terrane(&["bake", "cloudy.toml", "--levels", "0", "--out", "p.planet"], folder);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// Mean of all channels of a picture of the planet from afar.
fn brightness(folder: &Path, options: &[&str]) -> f64 {
    let shot =
        ["shot", "p.planet", "--stored-only", "--at", "10,20,90000", "--look", "0,-90", "--size", "64x64", "--out", "x.png"];
    let output = terrane(&[&shot[..], options].concat(), folder);
    assert!(output.status.success(), "{options:?}: {}", text(&output.stderr));
    let file = std::io::BufReader::new(std::fs::File::open(folder.join("x.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels.iter().map(|&x| f64::from(x)).sum::<f64>() / pixels.len() as f64
}

#[test]
fn dates_exposure_and_clouds_change_the_brightness() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    planet(folder);
    // At 20 degrees east it is noon at 10:40 UTC.
    let [noon, midnight] = ["2026-03-20T10:40Z", "2026-03-20T22:40Z"].map(|date| brightness(folder, &["--date", date]));
    assert!(noon > 5.0 * midnight, "noon {noon}, midnight {midnight}");
    let dim = brightness(folder, &["--date", "2026-03-20T10:40Z", "--exposure", "0.25"]);
    assert!(dim < 0.8 * noon, "noon {noon}, at a quarter {dim}");
    let soft = brightness(folder, &["--date", "2026-03-20T10:40Z", "--tone", "agx"]);
    assert!((soft / noon - 1.0).abs() < 0.3 && soft != noon, "noon {noon}, by AgX {soft}");
    let metered = brightness(folder, &["--date", "2026-03-20T22:40Z", "--exposure", "auto"]);
    assert!(metered > 1.5 * midnight, "midnight {midnight}, metered {metered}");
    let [cloudy, clear] = [&[][..], &["--clear-sky"]].map(|options| brightness(folder, options));
    assert!(cloudy > 1.04 * clear, "cloudy {cloudy}, clear {clear}");
}

#[test]
fn looks_that_make_no_sense_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let shot = ["shot", "p.planet", "--at", "10,20,90000", "--out", "x.png"];
    for (options, part) in [
        (&["--date", "yesterday"][..], "2026-06-21T12:00Z"),
        (&["--exposure", "bright"], "'auto'"),
        (&["--exposure", "0"], "1e-6"),
        (&["--tone", "sepia"], "neutral, agx"),
        (&["--sun", "10"], "2 numbers"),
        (&["--sun", "10,20", "--date", "2026-03-20T22:40Z"], "cannot be used with"),
    ] {
        let output = terrane(&[&shot[..], options].concat(), folder.path());
        assert!(!output.status.success() && text(&output.stderr).contains(part), "{options:?}: {}", text(&output.stderr));
    }
}
