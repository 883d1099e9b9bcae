//! Views as one line of text: pictures carry it and are drawn again from it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{device, terrane, text};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use terrane::stills::read_view;
use terrane_planet::draw::view_line::{Daylight, Stand, ViewLine};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;

fn shot(folder: &Path, options: &[&str], out: &str) -> Vec<u8> {
    let output = terrane(&[&["shot"], options, &["--out", out]].concat(), folder);
    assert!(output.status.success(), "{options:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{options:?}");
    pixels(&folder.join(out))
}

fn pixels(path: &Path) -> Vec<u8> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

fn line_of(path: &Path) -> String {
    read_view(BufReader::new(File::open(path).unwrap())).unwrap().unwrap()
}

fn bake(folder: &Path) {
    let output = terrane(&["bake", "tiny", "--cells", "16", "--levels", "1", "--out", "p.planet"], folder);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn a_picture_is_drawn_again_from_itself_and_from_its_text() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bake(folder);
    let by_sun = ["p.planet", "--at", "10.123456789,20.3,1500.7", "--look", "33.3,-12.1", "--fov", "41.7", "--size", "96x64"];
    let by_sun =
        [&by_sun[..], &["--sun", "100.5,12.25", "--error", "1.7", "--exposure", "1.3", "--spacing", "40", "--time", "7.5"]]
            .concat();
    let by_date = ["p.planet", "--at", "-5,100,90000", "--size", "64x64", "--date", "2026-03-20T08:30Z", "--exposure", "auto"];
    let by_date =
        [&by_date[..], &["--tone", "agx", "--ssaa", "2", "--depth", "16", "--transparent-sky", "--stored-only"]].concat();
    let lit =
        ["p.planet", "--at", "0,0,3000", "--size", "64x64", "--mode", "levels", "--no-geomorphs", "--orientation", "--clear-sky"];
    for (number, options) in [by_sun, by_date, lit.to_vec()].iter().enumerate() {
        let (first, again, by_text) = (format!("{number}.png"), format!("{number}-again.png"), format!("{number}-text.png"));
        let drawn = shot(folder, options, &first);
        let line = line_of(&folder.join(&first));
        assert!(
            shot(folder, &["p.planet", "--view", &first], &again) == drawn,
            "{line}: the picture's view shows something else"
        );
        assert!(shot(folder, &["p.planet", "--view", &line], &by_text) == drawn, "{line}: the text's view shows something else");
        assert_eq!(line_of(&folder.join(&again)), line);
        let moved = line.replace("/look=", "/look=1");
        assert!(shot(folder, &["p.planet", "--view", &moved], &by_text) != drawn, "{moved}: the check sees no other heading");
    }
}

#[test]
fn options_beside_a_view_go_first_and_heights_count_from_the_datum() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bake(folder);
    let view = "terrane:1/at=10,20/height=9000/size=64x48/sun=90,10/fov=30";
    shot(folder, &["p.planet", "--view", view, "--fov", "40", "--date", "2026-03-20T08:30Z"], "x.png");
    let line: ViewLine = line_of(&folder.join("x.png")).parse().unwrap();
    assert_eq!((line.at, line.stand), ([10.0, 20.0], Stand::Height(9000.0)));
    assert_eq!((line.fov, line.size, line.planet.as_deref()), (Some(40.0), Some([64, 48]), Some("Tiny")));
    assert!(matches!(line.daylight, Some(Daylight::Date(_))));
    let low = terrane(&["shot", "p.planet", "--view", "terrane:1/at=10,20/height=-9000", "--out", "y.png"], folder);
    assert!(text(&low.stderr).contains("height is -9000 m, expected"), "{}", text(&low.stderr));
}

#[test]
fn views_that_cannot_be_are_refused_with_place_found_and_expected() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("plain.png"), "no picture").unwrap();
    for (view, parts) in [
        ("46,8", &["'46,8' is no view", "terrane:1/"][..]),
        ("plain.png", &["cannot read plain.png as a PNG"]),
        ("gone.png", &["neither a picture nor a view", "gone.png"]),
        ("terrane:1/at=46,8/altitude=900/fov=500", &["character 32", "'500'", "7 to 140 degrees"]),
        ("terrane:9/at=46,8/altitude=900", &["version '9', expected 1"]),
        ("terrane:1/at=46,8", &["no altitude", "altitude=METRES"]),
    ] {
        let output = terrane(&["shot", "p.planet", "--view", view, "--out", "x.png"], folder);
        let message = text(&output.stderr);
        assert!(output.status.code() == Some(2) && parts.iter().all(|part| message.contains(part)), "{view}: {message}");
    }
}

#[test]
fn meshes_and_films_take_from_a_view_what_they_have_use_for() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bake(folder);
    let mesh = |options: &[&str]| {
        let output = terrane(&[&["mesh", "p.planet", "--out", "x.ply"], options].concat(), folder);
        assert!(output.status.success(), "{}", text(&output.stderr));
        std::fs::read(folder.join("x.ply")).unwrap()
    };
    let given = mesh(&["--at", "10,20,3000", "--look", "40,-20", "--fov", "30", "--size", "64x48", "--error", "2"]);
    let view = "terrane:1/at=10,20/altitude=3000/look=40,-20/fov=30/size=64x48/error=2/mode=albedo";
    assert!(mesh(&["--view", view]) == given && mesh(&["--view", view, "--look", "220,-20"]) != given);

    let keyframe = |time: f64| {
        format!(
            r#"{{"time_s": {time}, "latitude": 10, "longitude": 20, "altitude_m": 3000, "heading": 40, "pitch": -20, "fov": 30}}"#
        )
    };
    std::fs::write(folder.join("path.json"), format!("[{}, {}]", keyframe(0.0), keyframe(0.1))).unwrap();
    let record = ["record", "p.planet", "--path", "path.json", "--fps", "10", "--stored-only", "--view", view, "--out", "frames"];
    let output = terrane(&record, folder);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(pixels(&folder.join("frames/000001.png")) == shot(folder, &["p.planet", "--view", view, "--stored-only"], "x.png"));
}

#[test]
fn a_view_from_below_the_level_of_a_sea_that_is_left_out_is_drawn() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    bake(folder.path());
    let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 16).unwrap();
    let sites = (0..600).map(|k| [f64::from(k % 30) * 5.0 - 72.0, f64::from(k / 30) * 18.0 - 180.0]);
    let floor = |site: &[f64; 2]| planet.terrain.height(direction_at(site[0], site[1]));
    let [latitude, longitude] = sites.min_by(|a, b| floor(a).total_cmp(&floor(b))).unwrap();
    // Not far below the level: a coarse floor may be much higher than the terrain.
    let height = planet.recipe.sea.as_ref().unwrap().level_m - 5.0;
    assert!(floor(&[latitude, longitude]) < height - 100.0, "the sea is too shallow");
    let line = format!("terrane:1/at={latitude},{longitude}/height={height}/look=0,10/size=64x48/stored-only");
    let dived = shot(folder.path(), &["p.planet", "--view", &format!("{line}/no-sea")], "dived.png");
    assert!(dived.iter().any(|byte| *byte > 40), "the picture is black");
    let refused = terrane(&["shot", "p.planet", "--view", &line, "--out", "wet.png"], folder.path());
    assert!(text(&refused.stderr).contains("ground or sea there"), "{}", text(&refused.stderr));
}

/// Pixels of a picture in mode `error` that are beyond the tolerance (red), and within it (blue, green, yellow).
fn pixels_of_error(rgb: &[u8]) -> [usize; 2] {
    let is_red = |pixel: &&[u8]| f32::from(pixel[0]) > 1.5 * f32::from(pixel[1]);
    let ground: Vec<&[u8]> = rgb.chunks_exact(3).filter(|pixel| pixel.iter().any(|channel| *channel > 40)).collect();
    let red = ground.iter().filter(|pixel| is_red(pixel)).count();
    [red, ground.len() - red]
}

#[test]
fn the_error_of_a_whole_mesh_keeps_to_the_tolerance_and_where_patches_are_missing_it_is_said_to_be_more() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    bake(folder.path());
    let view = "terrane:1/at=35,45/altitude=1500/look=20,-40/size=96x64/sun=20,60/exposure=1/mode=error/no-air/clear-sky/no-sea";
    let whole = pixels_of_error(&shot(folder.path(), &["p.planet", "--view", view], "whole.png"));
    assert!(whole[0] == 0 && whole[1] > 4000, "{whole:?}");
    let coarse = ["p.planet", "--view", &format!("{view}/stored-only"), "--error", "0.2"];
    let coarse = pixels_of_error(&shot(folder.path(), &coarse, "coarse.png"));
    assert!(coarse[0] > 4000 && coarse[1] == 0, "{coarse:?}");
}
