//! Exposure by the picture itself and stars: nights become readable but stay darker than days, the same picture is exposed the same every time, and
//! stars do not twinkle when the camera turns.

use crate::harness::{device, planet_file};
use glam::DVec3;
use std::sync::Arc;
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::vulkan::Context;
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view::{Camera, View};

const SIZE: [u32; 2] = [320, 180];

/// Pixels and radiance of a view of the tiny planet, drawn by a new renderer.
fn show(context: &Arc<Context>, heading: f64, pitch: f64, elevation: f64, metering: Option<f32>) -> (Vec<u8>, Vec<f32>) {
    let mut scene = Scene::open(context, planet_file(), SceneOptions::default()).unwrap();
    let mut headless = Headless::new(context, (SIZE[0], SIZE[1])).unwrap();
    let site = DVec3::ONE.normalize();
    let planet = scene.planet();
    let position = planet.position_above(site, 60.0);
    let camera = Camera::looking(position, heading, pitch, 0.9, SIZE);
    let view = View::new(camera, scene.lattice(), planet.cells, 1.0);
    let cut = scene.settle(&view).unwrap();
    let look = Look {
        mode: Mode::Shaded,
        sun: sun_over(site, 200.0, elevation),
        exposure: 1.0,
        tone: Tone::Neutral,
        metering,
        ..Look::daylight(site)
    };
    headless.render(&scene, &view, &cut, &look).unwrap();
    (headless.pixels().unwrap(), headless.radiance().unwrap())
}

fn mean(pixels: &[u8]) -> f64 {
    let channels = pixels.chunks_exact(4).flat_map(|p| &p[..3]);
    channels.map(|&c| f64::from(c)).sum::<f64>() / (3 * pixels.len() / 4) as f64
}

#[test]
fn metering_makes_nights_readable_and_leaves_days_alone() {
    let Some(context) = device() else { return };
    let of = |elevation, metering| mean(&show(&context, 30.0, -5.0, elevation, metering).0);
    let (day, metered_day) = (of(50.0, None), of(50.0, Some(1.0)));
    let (night, metered_night) = (of(-40.0, None), of(-40.0, Some(1.0)));
    assert!((metered_day / day - 1.0).abs() < 0.3, "day {day}, metered {metered_day}");
    assert!(metered_night > 3.0 * night && metered_night < 0.6 * metered_day, "night {night}, metered {metered_night}");
}

#[test]
fn a_metered_picture_is_the_same_every_time() {
    let Some(context) = device() else { return };
    let [first, second] = [(); 2].map(|()| show(&context, 30.0, -5.0, 3.0, Some(1.0)).0);
    assert!(first == second);
    assert!(first != show(&context, 30.0, -5.0, 2.0, Some(1.0)).0);
}

#[test]
fn stars_are_as_bright_wherever_between_pixels_they_are() {
    let Some(context) = device() else { return };
    // The light of the brightest star in sight over the sky around it; a fifth of a pixel is 0.06 degrees.
    let light = |turn: f64| {
        let (_, radiance) = show(&context, 250.0 + 0.06 * turn, 45.0, -60.0, None);
        let green = |x: usize, y: usize| f64::from(radiance[4 * (y * SIZE[0] as usize + x) + 1]);
        let inner = (8..SIZE[1] as usize - 8).flat_map(|y| (8..SIZE[0] as usize - 8).map(move |x| (x, y)));
        let (x, y) = inner.max_by(|a, b| green(a.0, a.1).total_cmp(&green(b.0, b.1))).unwrap();
        let sum: f64 = (0..25).map(|k| green(x + k % 5 - 2, y + k / 5 - 2)).sum();
        let around = [green(x + 5, y), green(x - 5, y), green(x, y + 5), green(x, y - 5)];
        (sum - 25.0 * around.into_iter().fold(f64::MAX, f64::min), green(x, y))
    };
    let lights = [0.0, 1.0, 2.0, 3.0, 4.0].map(light);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let values = lights.iter().map(of);
        values.clone().fold(f64::MIN, f64::max) / values.fold(f64::MAX, f64::min)
    };
    assert!(lights[0].0 > 1e-3, "no star in sight: {lights:?}");
    assert!(range(|l| l.0) < 1.05, "{lights:?}");
    // The negative control: the brightest pixel alone does change.
    assert!(range(|l| l.1) > 1.07, "{lights:?}");
}
