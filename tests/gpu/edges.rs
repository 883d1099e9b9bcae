//! Outlines of the ground, drawn with one sample a pixel and with several: both are nearer to those of a picture with sixteen times the pixels
//! than one pixel of every sixteen is.

use crate::harness::{device_with, planet_file};
use glam::DVec3;
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view::{Camera, View};

const SIZE: [u32; 2] = [160, 90];

/// A picture of the planet's outline with `samples` a pixel, `finer` times as wide and high. Four bytes a pixel; `None` without a device.
fn outline(samples: u32, finer: u32) -> Option<Vec<u8>> {
    let context = device_with(Some(samples))?;
    assert_eq!(context.samples(), samples.min(context.most_samples()));
    let mut scene = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    let site = DVec3::new(1.0, 0.4, 0.3).normalize();
    let camera = Camera::looking(site * scene.planet().recipe.radius * 2.5, 30.0, -85.0, 0.9, SIZE.map(|side| finer * side));
    // All pictures show the same mesh: the tolerance is that of the small picture.
    let view = View::new(camera, scene.lattice(), scene.planet().cells, f64::from(finer));
    // Albedo is drawn without air, so that the outline is sharp.
    let look = Look {
        mode: Mode::Albedo,
        sun: sun_over(site, 135.0, 35.0),
        exposure: 1.0,
        tone: Tone::Neutral,
        metering: None,
        ..Look::daylight(site)
    };
    scene.set_sun(look.sun);
    let cut = scene.settle(&view).unwrap();
    let mut headless = Headless::new(&context, (finer * SIZE[0], finer * SIZE[1])).unwrap();
    headless.render(&scene, &view, &cut, &look).unwrap();
    Some(headless.pixels().unwrap())
}

/// Sum of the differences between the pixels of a picture and the means of their blocks in a finer one, where those hold both ground and
/// black space: elsewhere the finer picture has finer textures.
fn difference(picture: &[u8], finer: &[u8], times: usize) -> f64 {
    let width = SIZE[0] as usize;
    let mut sum = 0.0;
    for (k, pixel) in picture.chunks_exact(4).enumerate() {
        let (x, y) = (times * (k % width), times * (k / width));
        let part = (0..times * times).map(|i| 4 * ((y + i / times) * times * width + x + i % times));
        let is_space = |at: usize| finer[at..at + 3] == [0; 3];
        if part.clone().all(is_space) || !part.clone().any(is_space) {
            continue;
        }
        for channel in 0..3 {
            let mean = part.clone().map(|at| f64::from(finer[at + channel])).sum::<f64>() / (times * times) as f64;
            sum += (f64::from(pixel[channel]) - mean).abs();
        }
    }
    sum
}

/// One pixel of every block of a finer picture.
fn picked(finer: &[u8], times: usize) -> Vec<u8> {
    let [width, height] = SIZE.map(|side| side as usize);
    let middle = |k: usize| (times * (k / width) + times / 2) * times * width + times * (k % width) + times / 2;
    (0..width * height).flat_map(|k| finer[4 * middle(k)..][..4].to_vec()).collect()
}

#[test]
fn outlines_are_smooth() {
    let (Some(one), Some(four), Some(finer)) = (outline(1, 1), outline(4, 1), outline(1, 4)) else { return };
    let hard = picked(&finer, 4);
    let [one, four, hard] = [one, four, hard].map(|picture| difference(&picture, &finer, 4));
    println!("{one} with one sample, {four} with four, {hard} without edges");
    assert!(one < 0.6 * hard && four < 0.6 * hard, "{one} with one sample, {four} with four, {hard} without edges");
}
