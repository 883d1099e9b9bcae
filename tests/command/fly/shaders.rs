//! Shaders that are edited while a window is open (feature `hot-reload`).

use super::common::skipped;
use super::harness::{bake, display, end, terrane, Hand, Owned, FRAMES, PATIENCE};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

#[test]
fn shaders_are_drawn_with_as_they_are_edited_and_a_mistake_changes_nothing() {
    let Some((_server, display)) = display() else { return skipped(&"no Xvfb; apt install xvfb") };
    if Hand::xdotool(&display, &["version"]).is_none() {
        return skipped(&"no xdotool; apt install xdotool");
    }
    let folder = tempfile::tempdir().unwrap();
    let (planet, shaders) = (bake(folder.path()), folder.path().join("shaders"));
    let of_the_sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    assert!(Command::new("cp").arg("-r").arg(of_the_sources).arg(&shaders).status().unwrap().success());
    let mut command = terrane(&["fly", "--validate", "--size", "320x240", "--stored-only", "--screenshots"]);
    command.arg(folder.path()).arg("--shaders").arg(&shaders).arg(&planet).env("DISPLAY", &display);
    let mut flight = Owned(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    let hand = Hand::on(&display, &mut flight);
    let mut pictures = 0;
    let mut shown = || {
        pictures += 1;
        let picture = hand.picture(&folder.path().join(format!("terrane-{pictures}.png")));
        let at = 3 * (120 * 320 + 160);
        [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
    };
    let mut wait_for = |green: bool| {
        let begun = Instant::now();
        while (shown() == [0, 255, 0]) != green {
            assert!(begun.elapsed() < PATIENCE, "green: {}", !green);
            std::thread::sleep(FRAMES);
        }
    };
    wait_for(false);
    let (path, last) = (shaders.join("tonemap.frag"), "out_color = vec4(shown + dither / 255.0, 1.0);");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(last));
    let edit = |line: &str| std::fs::write(&path, text.replace(last, line)).unwrap();
    edit("out_color = vec4(0.0, 1.0, 0.0, 1.0);");
    wait_for(true);
    edit("out_color = vec4(0.0, 1.0, 0.0);");
    std::thread::sleep(4 * FRAMES);
    wait_for(true);
    // A binding more than the program knows of.
    std::fs::write(&path, text.replace("void main() {", "layout(binding = 9) uniform sampler2D more;\nvoid main() {")).unwrap();
    std::thread::sleep(4 * FRAMES);
    wait_for(true);
    edit(last);
    wait_for(false);
    hand.key("Escape");
    let (code, _, stderr) = end(flight);
    assert_eq!(code, Some(0), "{stderr}");
    for part in ["shaders stay as they were", "tonemap.frag:", "build it again"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert!(!stderr.contains("VUID"), "{stderr}");
}
