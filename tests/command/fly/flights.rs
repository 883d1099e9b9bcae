//! Windows as they are opened, flown, resized and closed, and paths that they play.

use super::common::{skipped, text};
use super::harness::{bake, display, end, terrane, Hand, Owned, Picture, FRAMES, SIZE};
use std::process::Stdio;
use std::time::{Duration, Instant};
use terrane::stills::read_view;
use terrane_planet::draw::view_line::ViewLine;

#[test]
fn a_flight_obeys_mouse_and_keys_and_leaves_validation_silent() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let planet = bake(folder.path());
    let mut command = terrane(&["fly", "--validate", "--size", "320x240", "--screenshots"]);
    command.arg(folder.path()).arg(&planet).env("DISPLAY", &display).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut flight = Owned(command.spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);

    let first = hand.picture(&folder.path().join("terrane-1.png"));
    assert_eq!(first.size, SIZE);
    assert!(first.colours() > 50, "{} colours", first.colours());
    assert!(first.brightness(160, 120) > first.brightness(3, 3) + 60, "the planet is not brighter than space");

    hand.does(&["mousemove", "120", "100", "mousedown", "1", "mousemove", "170", "130", "sleep", "0.3", "mouseup", "1"]);
    hand.does(&["click", "--repeat", "6", "4"]);
    std::thread::sleep(2 * FRAMES);
    let nearer = hand.picture(&folder.path().join("terrane-2.png"));
    assert!(nearer != first, "drag and wheel changed nothing");
    assert!(nearer.brightness(3, 3) > first.brightness(3, 3) || nearer.colours() > first.colours(), "the wheel came no nearer");

    for key in ["F1", "2", "3", "4", "5", "6", "m", "f", "l", "bracketright", "t", "F1", "1"] {
        hand.key(key);
    }
    hand.key("z");
    let frozen = hand.picture(&folder.path().join("terrane-3.png"));
    hand.key("Tab");
    hand.does(&["keydown", "w", "mousedown", "3", "mousemove", "150", "90", "sleep", "1", "keyup", "w", "mouseup", "3"]);
    let elsewhere = hand.picture(&folder.path().join("terrane-4.png"));
    assert!(elsewhere != frozen, "the view froze with the selection");
    hand.key("z");

    hand.does(&["windowsize", "--sync", &hand.window, "200", "150"]);
    std::thread::sleep(2 * FRAMES);
    hand.does(&["windowunmap", &hand.window]);
    std::thread::sleep(FRAMES);
    hand.does(&["windowmap", "--sync", &hand.window, "windowfocus", "--sync", &hand.window]);
    std::thread::sleep(FRAMES);
    assert_eq!(hand.picture(&folder.path().join("terrane-5.png")).size, (200, 150));

    hand.does(&["key", "Escape"]);
    let (code, stdout, stderr) = end(flight);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains(" frames in "), "{stdout}");
    assert_eq!(stderr, "");
}

#[test]
fn a_window_copies_its_view_and_a_still_shows_the_same() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let planet = bake(folder.path());
    let view = "terrane:1/at=10,20/altitude=9000/size=320x240/exposure=1/sun=90,30/stored-only/clear-sky";
    let mut command = terrane(&["fly", "--validate", "--view", view, "--screenshots"]);
    command.arg(folder.path()).arg(&planet).env("DISPLAY", &display).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut flight = Owned(command.spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);
    std::thread::sleep(3 * FRAMES);
    let shown = hand.picture(&folder.path().join("terrane-1.png"));
    hand.key("c");
    hand.key("Escape");
    let (code, stdout, stderr) = end(flight);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    let copied: ViewLine = stdout.lines().next().unwrap().parse().unwrap();
    assert_eq!((copied.at, copied.planet.as_deref(), copied.stored_only), ([10.0, 20.0], Some("Tiny"), true));

    let file = std::io::BufReader::new(std::fs::File::open(folder.path().join("terrane-1.png")).unwrap());
    let carried: ViewLine = read_view(file).unwrap().unwrap().parse().unwrap();
    assert_eq!(ViewLine { time: None, ..carried }, ViewLine { time: None, ..copied });
    let still = folder.path().join("still.png");
    let mut command = terrane(&["shot", "--view"]);
    command.arg(folder.path().join("terrane-1.png")).arg(&planet).arg("--out").arg(&still);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let still = Picture::read(&still);
    let difference = |other: &Picture| {
        let sum: u64 = shown.rgb.iter().zip(&other.rgb).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        sum as f64 / shown.rgb.len() as f64
    };
    assert!(still.size == shown.size && difference(&still) < 1.0, "{} steps of 255 apart", difference(&still));
    let turned = Picture { size: still.size, rgb: still.rgb.iter().rev().copied().collect() };
    assert!(difference(&turned) > 5.0, "the check sees nothing");
}

#[test]
fn without_a_file_it_flies_over_terra_and_keeps_what_it_builds() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let begun = Instant::now();
    let mut command = terrane(&["fly", "--size", "320x240", "--spacing", "100000", "--screenshots"]);
    command.arg(folder.path()).env("DISPLAY", &display).env("XDG_CACHE_HOME", folder.path().join("cache"));
    let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);
    let first = hand.picture(&folder.path().join("terrane-1.png"));
    println!("first picture saved after {:.2} s", begun.elapsed().as_secs_f64());
    assert!(first.colours() > 50 && first.brightness(160, 120) > first.brightness(3, 3) + 60, "{} colours", first.colours());
    hand.key("Escape");
    let (code, _, stderr) = end(flight);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    let kept = std::fs::read_dir(folder.path().join("cache/terrane")).unwrap().next().unwrap().unwrap();
    assert!(kept.file_name().to_string_lossy().starts_with("terra-"), "{kept:?}");
}

/// Ticks of the processor that a process has taken so far.
fn ticks(process: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // User and system time are fields 14 and 15; the first after the name is the third.
    fields[11..13].iter().map(|field| field.parse::<u64>().unwrap()).sum()
}

#[test]
fn a_path_is_played_with_fewer_pixels_than_it_ends_with_and_then_nothing_is_drawn() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    let folder = tempfile::tempdir().unwrap();
    let planet = bake(folder.path());
    let (path, report) = (folder.path().join("path.json"), folder.path().join("frames.json"));
    let keyframe = |time: f64, altitude: f64| {
        format!(
            r#"{{"time_s": {time}, "latitude": 10, "longitude": {time}, "altitude_m": {altitude}, "heading": 0, "pitch": -60, "fov": 50}}"#
        )
    };
    std::fs::write(&path, format!("[{}, {}]", keyframe(0.0, 9000.0), keyframe(8.0, 2000.0))).unwrap();
    let mut command = terrane(&["fly", "--validate", "--size", "320x240", "--stored-only", "--frame-ms", "1", "--path"]);
    command.arg(&path).arg("--report").arg(&report).arg(&planet).env("DISPLAY", &display);
    let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    // It flies for eight seconds and stands for five: the last two of them are still, once exposure has adapted.
    let mut taken = vec![0];
    while flight.0.try_wait().unwrap().is_none() {
        taken.push(ticks(flight.0.id()));
        std::thread::sleep(Duration::from_millis(500));
    }
    let (code, _, stderr) = end(flight);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    let frames: Vec<serde_json::Value> = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    let (moving, standing): (Vec<_>, Vec<_>) = frames.iter().skip(1).partition(|frame| frame["moving"] == true);
    assert!(moving.len() >= 5, "{} frames in flight", moving.len());
    // The first frames are those whose cost the budget is kept by.
    assert!(moving.iter().skip(3).all(|frame| frame["scale"] == 0.25), "a frame in flight has more pixels than its budget bears");
    let time = |frame: &serde_json::Value| frame["time_s"].as_f64().unwrap();
    // All pixels are there within half a second of standing still.
    let landed = time(moving.last().unwrap());
    let late: Vec<_> = standing.iter().filter(|frame| time(frame) < 1.0 || time(frame) > landed + 0.5).collect();
    assert!(late.iter().all(|frame| frame["scale"] == 1.0), "who stands does not see all pixels");
    assert!(standing.last().is_some_and(|frame| frame["scale"] == 1.0), "the last frame does not have all pixels");
    let stood = time(frames.last().unwrap()) - landed;
    assert!(stood < 4.0, "the last frame came after {stood} s of standing still");
    // The very last may have seen it closing.
    let still = taken[taken.len() - 2] - taken[taken.len() - 4];
    println!("{} frames in flight, {} standing, {still} ticks in the last second", moving.len(), standing.len());
    assert!(still <= 5, "{still} ticks of the processor in a second in which nothing changed");
}

#[test]
fn without_a_display_it_says_so_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let planet = bake(folder.path());
    for (display, found) in [(None, "DISPLAY is not set"), (Some(":987"), "DISPLAY is ':987'")] {
        let mut command = terrane(&["fly"]);
        command.arg(&planet).env_remove("DISPLAY");
        if let Some(display) = display {
            command.env("DISPLAY", display);
        }
        let output = command.output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        for part in ["no window system", found, "WAYLAND_DISPLAY is not set", "terrane shot", "terrane record"] {
            assert!(message.contains(part), "{part}: {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn a_file_that_is_no_planet_is_refused_before_a_window_opens() {
    let folder = tempfile::tempdir().unwrap();
    let notes = folder.path().join("notes.planet");
    std::fs::write(&notes, "some notes\n").unwrap();
    let output = terrane(&["fly"]).arg(&notes).env_remove("DISPLAY").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("notes.planet"), "{}", text(&output.stderr));
}
