//! A window that fills the screen. Only a window manager can have it do so, so one runs here.

use super::common::skipped;
use super::harness::{bake, display, end, terrane, Hand, Owned, FRAMES, PATIENCE, SCREEN, SIZE};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// A small window manager with its usual settings. None where it is not installed.
fn window_manager(display: &str, home: &Path) -> Option<Owned> {
    let mut command = Command::new("openbox");
    command.arg("--sm-disable").env("DISPLAY", display).env("XDG_CONFIG_HOME", home).env("XDG_DATA_HOME", home);
    let manager = Owned(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()?);
    let begun = Instant::now();
    while !Hand::xdotool(display, &["get_num_desktops"])?.status.success() {
        assert!(begun.elapsed() < PATIENCE, "openbox does not manage windows");
        std::thread::sleep(FRAMES / 10);
    }
    Some(manager)
}

#[test]
fn a_key_fills_the_screen_and_again_gives_it_back() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let Some(_manager) = window_manager(&display, folder.path()) else { return skipped(&"no openbox; apt install openbox") };
    let planet = bake(folder.path());
    let mut command = terrane(&["fly", "--validate", "--size", "320x240", "--stored-only", "--screenshots"]);
    command.arg(folder.path()).arg(&planet).env("DISPLAY", &display);
    let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);
    let mut pictures = 0;
    let mut wait_for = |size: (u32, u32)| {
        let begun = Instant::now();
        loop {
            pictures += 1;
            let found = hand.picture(&folder.path().join(format!("terrane-{pictures}.png"))).size;
            if found == size {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "the window is of {found:?} pixels, expected {size:?}");
            std::thread::sleep(FRAMES);
        }
    };
    wait_for(SIZE);
    for size in [SCREEN, SIZE] {
        hand.key("F11");
        wait_for(size);
    }
    hand.key("Escape");
    let (code, _, stderr) = end(flight);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
}
