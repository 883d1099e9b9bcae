//! `terrane record` and the pictures of `terrane shot` as processes: recordings that resume, films encoded by a script in place of
//! ffmpeg, and formats.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{device, terrane, text};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const PATH: &str = r#"[
    {"time_s": 0, "latitude": 10, "longitude": 20, "altitude_m": 20000, "heading": 0, "pitch": -40, "fov": 50},
    {"time_s": 1, "latitude": 12, "longitude": 22, "altitude_m": 9000, "heading": 30, "pitch": -30, "fov": 50}
]"#;

/// A folder with a planet and a path.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let bake = ["bake", &recipe.to_string_lossy(), "--cells", "32", "--levels", "1", "--out", "tiny.planet"];
    let output = terrane(&bake, folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    std::fs::write(folder.path().join("path.json"), PATH).unwrap();
    folder
}

const RECORD: [&str; 9] = ["record", "tiny.planet", "--stored-only", "--path", "path.json", "--fps", "3", "--size", "96x64"];

/// Records with a PATH that holds only `bin`.
fn record_with(bin: &Path, out: &str, folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(RECORD).args(["--json", "--out", out]).current_dir(folder).env("PATH", bin).stdin(Stdio::null());
    command.output().unwrap()
}

#[test]
fn a_recording_goes_on_where_it_stopped_and_only_with_the_same_options() {
    if device().is_none() {
        return;
    }
    let folder = folder();
    let record = |more: &[&str]| terrane(&[&RECORD[..], &["--out", "frames", "--json"], more].concat(), folder.path());
    let tally = |output: &Output| {
        assert!(output.status.success(), "{}", text(&output.stderr));
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        ["frames", "drawn", "kept"].map(|key| json[key].as_u64().unwrap())
    };
    let first = record(&[]);
    assert_eq!(tally(&first), [4, 4, 0]);
    assert!(text(&first.stderr).contains("4/4 frames"), "no progress: {}", text(&first.stderr));
    let frame = |number: u32| folder.path().join(format!("frames/{number:06}.png"));
    let bytes = std::fs::read(frame(3)).unwrap();
    assert!(bytes != std::fs::read(frame(4)).unwrap(), "the camera stands still");
    std::fs::remove_file(frame(3)).unwrap();
    assert_eq!(tally(&record(&[])), [4, 1, 3]);
    assert!(bytes == std::fs::read(frame(3)).unwrap(), "a frame depends on those before it");

    let other = record(&["--exposure", "2"]);
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stderr).contains("another look"), "{}", text(&other.stderr));
}

#[cfg(unix)]
#[test]
fn films_are_made_by_ffmpeg_and_nothing_is_drawn_without_it() {
    use std::os::unix::fs::PermissionsExt;
    if device().is_none() {
        return;
    }
    let folder = folder();
    let bin = folder.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    let without = record_with(&bin, "film.mp4", folder.path());
    let said = text(&without.stderr);
    assert_eq!(without.status.code(), Some(1), "{said}");
    assert!(said.contains("ffmpeg was not found") && said.contains("apt install ffmpeg") && !said.contains("frames,"), "{said}");

    let stand_in = |script: &str| {
        let path = bin.join("ffmpeg");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    };
    // A script that writes its arguments into a file, and its input as the film.
    stand_in("echo \"$@\" > arguments; for last; do :; done; exec /bin/cat > \"$last\"");
    let with = record_with(&bin, "film.webm", folder.path());
    assert!(with.status.success(), "{}", text(&with.stderr));
    assert_eq!(std::fs::read(folder.path().join("film.webm")).unwrap().len(), 4 * 96 * 64 * 4);
    let arguments = std::fs::read_to_string(folder.path().join("arguments")).unwrap();
    for part in ["-s 96x64", "-r 3", "libvpx-vp9", "yuv420p", "-f webm"] {
        assert!(arguments.contains(part), "{part}: {arguments}");
    }

    stand_in("echo 'no room for a film' >&2; exit 3");
    let broken = record_with(&bin, "broken.mp4", folder.path());
    let said = text(&broken.stderr);
    assert_eq!(broken.status.code(), Some(1), "{said}");
    assert!(said.contains("no room for a film") && said.contains("ffmpeg"), "{said}");
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains("broken")), "{left:?}");
}

#[test]
fn what_cannot_be_recorded_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("path.json"), PATH).unwrap();
    let record = ["record", "tiny.planet", "--path", "path.json"];
    for (more, part) in [
        (vec!["--out", "film.avi"], ".avi is neither a film"),
        (vec!["--out", "film.mp4", "--size", "97x64"], "97x64"),
        (vec!["--out", "frames", "--fps", "0"], "--fps"),
        (vec!["--out", "frames", "--ssaa", "9"], "1..=4"),
        (vec!["--out", "frames", "--size", "20000x64"], "16384"),
    ] {
        let output = terrane(&[&record[..], &more].concat(), folder.path());
        assert!(!output.status.success() && text(&output.stderr).contains(part), "{part}: {}", text(&output.stderr));
    }
}

#[test]
fn pictures_come_as_png_of_8_and_16_bits_and_as_radiance() {
    if device().is_none() {
        return;
    }
    let folder = folder();
    let shot = |out: &str, more: &[&str]| {
        let arguments = ["shot", "tiny.planet", "--stored-only", "--size", "80x60", "--out", out];
        let output = terrane(&[&arguments[..], more].concat(), folder.path());
        assert!(output.status.success(), "{}", text(&output.stderr));
        folder.path().join(out)
    };
    let kind = |path: &Path| {
        let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
        (reader.info().color_type, reader.info().bit_depth)
    };
    assert_eq!(kind(&shot("a.png", &[])), (png::ColorType::Rgb, png::BitDepth::Eight));
    let deep = shot("b.png", &["--depth", "16", "--transparent-sky", "--ssaa", "2"]);
    assert_eq!(kind(&deep), (png::ColorType::Rgba, png::BitDepth::Sixteen));

    let path = shot("c.exr", &["--transparent-sky", "--sun", "120,40"]);
    let image = exr::prelude::read_first_rgba_layer_from_file(
        &path,
        |size, _| vec![[0.0f32; 4]; size.width() * size.height()],
        |pixels, at, (r, g, b, a): (f32, f32, f32, f32)| pixels[80 * at.y() + at.x()] = [r, g, b, a],
    )
    .unwrap();
    let pixels = &image.layer_data.channel_data.pixels;
    assert_eq!((pixels[0], pixels[80 * 30 + 40][3]), ([0.0; 4], 1.0), "space, and ground in the middle");
    assert!(pixels.iter().any(|p| p[0] > 0.01) && pixels.iter().all(|p| p.iter().all(|c| c.is_finite())));
    let names: Vec<String> = image.layer_data.attributes.other.keys().map(ToString::to_string).collect();
    for name in ["displayExposure", "displayTone", "displayWhite", "cameraForward", "sunDirection", "planet"] {
        assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
    }
    assert!(image.layer_data.attributes.latitude.is_some());
}

#[test]
fn a_strip_has_the_frames_of_its_path_side_by_side() {
    if device().is_none() {
        return;
    }
    let folder = folder();
    let arguments = ["record", "tiny.planet", "--stored-only", "--path", "path.json", "--size", "60x40", "--strip", "3", "--out"];
    for out in ["strip.png", "strip.jpg"] {
        let output = terrane(&[&arguments[..], &[out]].concat(), folder.path());
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let record =
        ["record", "tiny.planet", "--stored-only", "--path", "path.json", "--size", "60x40", "--fps", "2", "--out", "frames"];
    assert!(terrane(&record, folder.path()).status.success());
    let read = |path: &str| {
        let file = std::io::BufReader::new(std::fs::File::open(folder.path().join(path)).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        (info.width as usize, rgb)
    };
    let (width, strip) = read("strip.png");
    assert_eq!((width, strip.len()), (188, 3 * 188 * 40));
    for number in 1..=3 {
        let (_, frame) = read(&format!("frames/{number:06}.png"));
        let rows = (0..40).map(|row| &strip[3 * (row * 188 + 64 * (number - 1))..][..180]);
        assert!(rows.zip(frame.chunks(180)).all(|(a, b)| a == b), "frame {number} is another");
    }
    let jpeg = std::fs::read(folder.path().join("strip.jpg")).unwrap();
    assert!(jpeg.starts_with(&[0xff, 0xd8]) && jpeg.len() < strip.len());
    let refused = terrane(&[&arguments[..], &["strip.gif"]].concat(), folder.path());
    assert!(text(&refused.stderr).contains(".png"), "{}", text(&refused.stderr));
}
