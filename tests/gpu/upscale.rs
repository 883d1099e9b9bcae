//! Pictures drawn with fewer pixels than they have: of the same mesh, smoother than their pixels made larger, and without effect on what is
//! drawn with all of them later.

use crate::harness::{device, planet_file};
use glam::DVec3;
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::EmitState;
use terrane_planet::draw::view::{Camera, View};

const SIZE: [u32; 2] = [256, 144];

struct Stand {
    scene: Scene,
    headless: Headless,
    view: View,
    cut: Cut,
    look: Look,
}

impl Stand {
    /// The limb of the tiny planet over `divisor` times fewer pixels a side; of the same mesh.
    fn new(divisor: u32) -> Option<Stand> {
        let context = device()?;
        let mut scene = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
        let site = DVec3::new(1.0, 0.9, 0.8).normalize();
        let size = SIZE.map(|side| side / divisor);
        let camera = Camera::looking(site * scene.planet().recipe.radius * 1.2, 30.0, -50.0, 0.9, size);
        let view = View::new(camera, scene.lattice(), scene.planet().cells, 1.0 / f64::from(divisor));
        let look = Look::daylight(sun_over(site, 135.0, 35.0));
        scene.set_sun(look.sun);
        let cut = scene.settle(&view).unwrap();
        let headless = Headless::new(&context, (size[0], size[1])).unwrap();
        Some(Stand { scene, headless, view, cut, look })
    }

    fn draw(&mut self, density: f64) -> (Vec<u8>, EmitState) {
        self.headless.renderer.set_density(density).unwrap();
        let report = self.headless.render(&self.scene, &self.view, &self.cut, &self.look).unwrap();
        (self.headless.pixels().unwrap(), report.counters)
    }
}

/// Mean difference of two pictures' channels, in steps of 255.
fn difference(one: &[u8], other: &[u8]) -> f64 {
    let sum: u64 = one.iter().zip(other).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / one.len() as f64
}

/// A picture with every pixel as a square of `times` pixels.
fn enlarged(picture: &[u8], times: usize) -> Vec<u8> {
    let [width, height] = SIZE.map(|side| side as usize);
    let pixel = |k: usize| 4 * ((k / width / times) * (width / times) + k % width / times);
    (0..width * height).flat_map(|k| picture[pixel(k)..][..4].to_vec()).collect()
}

#[test]
fn fewer_pixels_show_the_same_mesh_better_than_larger_pixels_do() {
    let (Some(mut stand), Some(mut small)) = (Stand::new(1), Stand::new(2)) else { return };
    let (all, counters) = stand.draw(1.0);
    let blocks = difference(&enlarged(&small.draw(1.0).0, 2), &all);
    for (density, most) in [(0.75, 0.5), (0.5, 0.8), (0.25, 1.6)] {
        let (few, counted) = stand.draw(density);
        let found = difference(&few, &all);
        println!("density {density}: {found:.2}, blocks of 2 x 2 pixels {blocks:.2}");
        assert!(found > 0.0 && found < most * blocks, "density {density}: {found}, blocks of 2 x 2 pixels {blocks}");
        assert_eq!(counted.wanted, counters.wanted, "density {density}");
    }
    assert!(stand.draw(1.0).0 == all, "what was drawn with fewer pixels changes what is drawn with all");
}

#[test]
fn odd_sizes_are_enlarged_too() {
    let Some(mut stand) = Stand::new(1) else { return };
    stand.headless.resize((101, 57)).unwrap();
    for density in [0.375, 0.01] {
        let (picture, _) = stand.draw(density);
        assert_eq!(picture.len(), 4 * 101 * 57);
        assert!(picture.chunks_exact(4).all(|pixel| pixel[3] == 255), "density {density}: pixels are missing");
    }
}
