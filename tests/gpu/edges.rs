//! Edges of the ground with several samples a pixel: between those of one sample and those of a picture sixteen times as large.

use crate::harness::{device_with, planet_file};
use glam::DVec3;
use terrane::frame::{sun_over, Look, DAYLIGHT};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane_planet::draw::layout::Mode;
use terrane_planet::draw::view::{Camera, View};

const SIZE: [u32; 2] = [160, 90];

/// The planet's outline in so many samples a pixel, and `finer` times as large. Four bytes a pixel; `None` without a device.
fn outline(samples: u32, finer: u32) -> Option<Vec<u8>> {
    let context = device_with(Some(samples))?;
    assert_eq!(context.samples(), samples.min(context.most_samples()));
    let mut scene = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    let place = DVec3::new(1.0, 0.4, 0.3).normalize();
    let camera = Camera::looking(place * scene.planet().recipe.radius * 2.5, 30.0, -85.0, 0.9, SIZE.map(|side| finer * side));
    // The same mesh for all: the tolerance is that of the small picture.
    let view = View::new(camera, scene.lattice(), scene.planet().cells, f64::from(finer));
    // Without air the outline is as sharp as it can be.
    let look = Look { mode: Mode::Albedo, sun: sun_over(place, 135.0, 35.0), exposure: DAYLIGHT, metering: None, clouds: true };
    scene.set_sun(look.sun);
    let cut = scene.settle(&view).unwrap();
    let mut headless = Headless::new(&context, (finer * SIZE[0], finer * SIZE[1])).unwrap();
    headless.render(&scene, &view, &cut, &look).unwrap();
    Some(headless.pixels().unwrap())
}

/// Sum of the differences from the mean of each pixel's part of a finer picture.
fn difference(picture: &[u8], finer: &[u8], times: usize) -> f64 {
    let width = SIZE[0] as usize;
    let mut sum = 0.0;
    for (k, pixel) in picture.chunks_exact(4).enumerate() {
        let (x, y) = (times * (k % width), times * (k / width));
        let part = (0..times * times).map(|i| 4 * ((y + i / times) * times * width + x + i % times));
        for channel in 0..3 {
            let mean = part.clone().map(|at| f64::from(finer[at + channel])).sum::<f64>() / (times * times) as f64;
            let apart = (f64::from(pixel[channel]) - mean).abs();
            // Edges, not grain.
            sum += if apart > 12.0 { apart } else { 0.0 };
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
