//! The atmosphere in pictures from 2 m to 100,000 km, against numerical integration in f64. Differences are in 8-bit steps after the
//! tonemap, as a viewer would see them.

use crate::harness::{device, large_planet_file, pixel_ray, planet_file};
use glam::DVec3;
use std::path::Path;
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::vulkan::Context;
use terrane_planet::draw::layout::{Mode, Shading, Tone, SUN_RADIUS};
use terrane_planet::draw::tone::Curve;
use terrane_planet::draw::view::{Camera, View, NEAR};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::reference::air::Air;
use terrane_planet::reference::tonemap::display;

const SIZE: [u32; 2] = [96, 54];
/// Largest difference that passes, in steps of 1/255. The largest is that of the last light on a small planet; by day it is below one.
const LARGEST: f64 = 2.75;
/// Pixels compared in each picture.
const SAMPLES: usize = 48;

/// Metres above the ground, pitch and vertical field of view in degrees, and the sun's azimuth and elevation. All views look north-east.
type Viewpoint = (f64, f64, f64, [f64; 2]);

const VIEWPOINTS: [Viewpoint; 26] = [
    (2.0, 3.0, 50.0, [45.0, 10.0]),
    (2.0, 0.0, 8.0, [45.0, 0.5]),
    (2.0, 20.0, 90.0, [90.0, 60.0]),
    (2.0, 0.0, 60.0, [60.0, -4.0]),
    (60.0, -1.0, 50.0, [200.0, 35.0]),
    (60.0, 1.0, 30.0, [30.0, 2.0]),
    (1500.0, -5.0, 50.0, [225.0, 3.0]),
    (1500.0, -2.0, 40.0, [45.0, 30.0]),
    (9000.0, -5.0, 50.0, [60.0, 5.0]),
    (9000.0, -40.0, 60.0, [10.0, 45.0]),
    (9000.0, -3.0, 10.0, [45.0, -1.0]),
    (30e3, -6.0, 40.0, [45.0, 4.0]),
    (30e3, -30.0, 60.0, [300.0, 70.0]),
    (9e4, -10.0, 50.0, [45.0, 12.0]),
    (9.7e4, -9.0, 30.0, [45.0, -8.0]),
    (3e5, -18.0, 30.0, [60.0, 40.0]),
    (3e5, -17.0, 12.0, [45.0, -15.0]),
    (3e5, -60.0, 50.0, [120.0, 5.0]),
    (3e6, -50.0, 30.0, [45.0, 0.0]),
    (3e6, -90.0, 70.0, [45.0, 60.0]),
    (1.2e7, -90.0, 50.0, [270.0, 0.0]),
    (1.2e7, -90.0, 50.0, [135.0, 35.0]),
    (1.2e7, -71.0, 2.0, [45.0, 5.0]),
    (1.2e7, -90.0, 50.0, [90.0, -60.0]),
    (1e8, -90.0, 8.0, [135.0, 20.0]),
    (1e8, -90.0, 8.0, [45.0, -75.0]),
];

/// The images of one frame, and what brute force needs to know of it.
struct Picture {
    camera: Camera,
    shading: Shading,
    sun: DVec3,
    with_air: Vec<f32>,
    without: Vec<f32>,
    depth: Vec<f32>,
    shore: Vec<f32>,
}

struct Studio {
    scene: Scene,
    headless: Headless,
}

impl Studio {
    fn new(context: &std::sync::Arc<Context>, file: &Path) -> Studio {
        let scene = Scene::open(context, file, SceneOptions::default()).unwrap();
        Studio { scene, headless: Headless::new(context, (SIZE[0], SIZE[1])).unwrap() }
    }

    /// Draws the view of a viewpoint. Altitudes are multiplied by `scale`, for planets smaller than the Earth.
    fn show(&mut self, (altitude, pitch, fov, [azimuth, elevation]): Viewpoint, scale: f64) -> Picture {
        let planet = self.scene.planet();
        let site = direction_at(36.62, 106.05);
        let position = planet.position_above(site, (altitude * scale).max(2.0));
        let camera = Camera::looking(position, 45.0, pitch, fov.to_radians(), SIZE);
        let view = View::new(camera, self.scene.lattice(), planet.cells, 1.0);
        let cut = self.scene.settle(&view).unwrap();
        let sun = sun_over(site, azimuth, elevation);
        let look = Look { clouds: false, ..Look::daylight(sun) };
        self.headless.render(&self.scene, &view, &cut, &look).unwrap();
        Picture {
            camera,
            shading: *self.headless.shading(),
            sun,
            with_air: self.headless.radiance().unwrap(),
            without: self.headless.surface().unwrap(),
            depth: self.headless.depth().unwrap(),
            shore: self.headless.shore().unwrap(),
        }
    }
}

impl Picture {
    /// Pixels spread over the picture.
    fn samples() -> impl Iterator<Item = usize> {
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        (0..SAMPLES).map(move |k| (k * pixels + pixels / 2) / SAMPLES + k * 17 % SIZE[0] as usize).map(move |k| k % pixels)
    }

    /// Metres along a unit ray to what a pixel shows.
    fn distance(&self, pixel: usize, ray: DVec3, stretch: f64) -> f64 {
        let depth = f64::from(self.depth[pixel]);
        let ground = if depth > 0.0 { f64::from(NEAR) / depth * stretch } else { f64::INFINITY };
        let radius = f64::from(self.shading.radius + self.shading.sea_level);
        let (along, aside) = (self.camera.position.dot(ray), self.camera.position.cross(ray).length());
        let sea = aside < radius && along < 0.0 && (depth <= 0.0 || self.shore[pixel] < 0.0);
        if sea {
            -along - ((radius - aside) * (radius + aside)).sqrt()
        } else {
            ground
        }
    }

    /// The largest difference of a sampled pixel from brute force in 8-bit steps, with the pixel's number and both colours.
    fn largest_difference(&self, air: &Air) -> (f64, usize, [DVec3; 2]) {
        let (curve, exposure) = (Curve::new(Tone::Neutral, 0.85), self.shading.exposure);
        let differences = Picture::samples().filter_map(|pixel| {
            let direction = pixel_ray(&self.camera, pixel);
            let ray = direction.normalize();
            let distance = self.distance(pixel, ray, direction.length());
            if distance.is_infinite() && ray.angle_between(self.sun) < 3.0 * SUN_RADIUS {
                return None;
            }
            let at =
                |values: &[f32]| DVec3::new(values[4 * pixel].into(), values[4 * pixel + 1].into(), values[4 * pixel + 2].into());
            let (scattered, passed) = air.before(self.camera.position, ray, distance, self.sun);
            let behind = if distance.is_infinite() { air.glare(self.camera.position, ray, self.sun) } else { at(&self.without) };
            let colours = [at(&self.with_air), behind * passed + scattered];
            let [found, expected] =
                colours.map(|colour| 255.0 * display(Mode::Shaded, &curve, exposure, colour.as_vec3()).as_dvec3());
            Some(((found - expected).abs().max_element(), pixel, [found, expected]))
        });
        differences.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

#[test]
fn air_differs_from_brute_force_by_less_than_can_be_seen() {
    let Some(context) = device() else { return };
    let mut faults = Vec::new();
    let mut worst = 0.0f64;
    for (file, scale) in [(large_planet_file(), 1.0), (planet_file(), 30.0 / 6371.0)] {
        let mut studio = Studio::new(&context, file);
        let mut air = None;
        for viewpoint in VIEWPOINTS {
            let picture = studio.show(viewpoint, scale);
            let air = air.get_or_insert_with(|| Air::new(&picture.shading).unwrap());
            let (difference, pixel, colours) = picture.largest_difference(air);
            worst = worst.max(difference);
            println!("{difference:6.2} {viewpoint:?} x {scale:.4}, pixel {} {}: {colours:.1?}", pixel % 96, pixel / 96);
            if difference > LARGEST {
                faults.push(format!("{difference:.2} steps at {viewpoint:?}, scale {scale}, pixel {pixel}"));
            }
        }
    }
    println!("largest difference: {worst:.2} steps of 8 bits");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn air_one_part_in_ten_denser_is_noticed() {
    let Some(context) = device() else { return };
    let mut studio = Studio::new(&context, large_planet_file());
    for viewpoint in [VIEWPOINTS[4], VIEWPOINTS[9], VIEWPOINTS[15], VIEWPOINTS[21]] {
        let picture = studio.show(viewpoint, 1.0);
        let dense = Shading { rayleigh: picture.shading.rayleigh.map(|x| 1.1 * x), ..picture.shading };
        let (difference, ..) = picture.largest_difference(&Air::new(&dense).unwrap());
        assert!(difference > LARGEST, "{difference} steps at {viewpoint:?}");
    }
}
