//! Outlines of the ground drawn with several samples a pixel: they are nearer to those of a picture with sixteen times the pixels than
//! outlines drawn with one sample are.

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
        clouds: true,
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

#[test]
fn edges_are_smoother_with_several_samples() {
    let (Some(one), Some(four), Some(finer)) = (outline(1, 1), outline(4, 1), outline(1, 4)) else { return };
    let [one, four] = [one, four].map(|picture| difference(&picture, &finer, 4));
    assert!(four < 0.6 * one, "{four} where one sample has {one}");
}
