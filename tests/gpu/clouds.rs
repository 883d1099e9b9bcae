//! Clouds lie where the map says, seen from all sides; a picture drawn in tiles has the same clouds; diagrams have none.

use crate::harness::{cloudy_planet_file, device, pixel_ray};
use glam::DVec3;
use std::sync::Arc;
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::stills::{Pixels, StillOptions, Studio};
use terrane::vulkan::Context;
use terrane_planet::draw::layout::Mode;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::maps::clouds::{cloud_levels, cloud_map, octahedral, CloudLevel, CLOUD_EDGE, CLOUD_SIDE};

const SIZE: [u32; 2] = [96, 96];
/// Radii of the planet and of its clouds in metres.
const RADIUS: f64 = 30_000.0;
const CLOUDS: f64 = 31_500.0;
/// Distance of the eye from the planet's centre, in radii of the planet.
const FAR: f64 = 6.0;
/// The most that the detail adds to a value of the map, and by how much a value exceeds the edge of clouds where they are thick.
const DETAIL: f32 = 0.16;
const THICK: f32 = 0.4;

struct Sky {
    scene: Scene,
    headless: Headless,
}

impl Sky {
    fn new(context: &Arc<Context>) -> Sky {
        let scene = Scene::open(context, cloudy_planet_file(), SceneOptions::default()).unwrap();
        Sky { scene, headless: Headless::new(context, (SIZE[0], SIZE[1])).unwrap() }
    }

    fn view(&self, position: DVec3, pitch: f64, fov: f64) -> View {
        View::new(Camera::looking(position, 0.0, pitch, fov, SIZE), self.scene.lattice(), self.scene.planet().cells, 1.0)
    }

    /// The camera above a direction with the sun behind it, and the radiance of its picture.
    fn seen_from_afar(&mut self, direction: DVec3, mode: Mode, clouds: bool) -> (Camera, Vec<f32>) {
        let view = self.view(direction * (FAR * RADIUS), -90.0, 0.11);
        let cut = self.scene.settle(&view).unwrap();
        let look = Look { mode, clouds, ..Look::daylight(direction) };
        self.headless.render(&self.scene, &view, &cut, &look).unwrap();
        (view.camera, self.headless.radiance().unwrap())
    }
}

/// Where a pixel's ray meets the layer of clouds, as a direction from the planet's centre; `None` near the limb.
fn cloud_direction(camera: &Camera, pixel: usize) -> Option<DVec3> {
    let ray = pixel_ray(camera, pixel).normalize();
    let along = -camera.position.dot(ray);
    let aside = camera.position.cross(ray).length();
    let near = along - (CLOUDS * CLOUDS - aside * aside).sqrt();
    (aside < 0.8 * RADIUS).then(|| (camera.position + ray * near).normalize())
}

/// Smallest and largest value of a level around a direction.
fn around(level: &CloudLevel, side: usize, direction: DVec3) -> [f32; 2] {
    let [x, y] = octahedral(direction).map(|c| 0.5 * (c + 1.0) * (side - 1) as f64);
    let texels = (0..=1).flat_map(|j| (0..=1).map(move |i| (x as i64 + i, y as i64 + j)));
    let inside = |k: i64| k.clamp(0, side as i64 - 1) as usize;
    texels.map(|(i, j)| f32::from(level[inside(j) * side + inside(i)]) / 255.0).fold([1.0, 0.0], |[a, b], v| [a.min(v), b.max(v)])
}

#[test]
fn clouds_lie_where_the_map_says() {
    let Some(context) = device() else { return };
    let mut sky = Sky::new(&context);
    let recipe = &sky.scene.shared_planet().recipe;
    let map = cloud_levels(cloud_map(recipe, recipe.clouds.as_ref().unwrap(), CLOUD_SIDE), CLOUD_SIDE);
    // Corners, edges and sides of the octahedron.
    let directions =
        [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y, DVec3::new(1.0, -1.0, 0.0), DVec3::new(-1.0, 0.4, -0.8), DVec3::ONE];
    let more = (0..17).map(|k| direction_at(f64::from(k * 10 - 80), f64::from(k * 137 % 360)));
    let (mut thick, mut hidden, mut clear, mut changed, mut elsewhere) = (0, 0, 0, 0, 0);
    for over in directions.map(DVec3::normalize).into_iter().chain(more) {
        let (camera, cloudy) = sky.seen_from_afar(over, Mode::Shaded, true);
        let (_, bare) = sky.seen_from_afar(over, Mode::Shaded, false);
        let pixel_m = (FAR - 1.0) * RADIUS * 2.0 * camera.half_extents().1 / f64::from(SIZE[1]);
        let texel_m = 3.545 * CLOUDS / CLOUD_SIDE as f64;
        let power = (pixel_m / texel_m).log2().round() as usize;
        for pixel in 0..(SIZE[0] * SIZE[1]) as usize {
            let Some(direction) = cloud_direction(&camera, pixel) else { continue };
            let [low, high] = around(&map[power], CLOUD_SIDE >> power, direction);
            let [with, without] = [&cloudy, &bare].map(|p| p[4 * pixel] + p[4 * pixel + 1] + p[4 * pixel + 2]);
            let differs = (with - without).abs() > 0.03 * without;
            if low > CLOUD_EDGE + THICK {
                thick += 1;
                hidden += usize::from(differs);
            } else if high < CLOUD_EDGE - DETAIL {
                clear += 1;
                changed += usize::from(differs);
                let mirrored = DVec3::new(direction.x, -direction.y, direction.z);
                elsewhere += usize::from(around(&map[power], CLOUD_SIDE >> power, mirrored)[0] > CLOUD_EDGE);
            }
        }
    }
    println!("{hidden} of {thick} thick, {changed} of {clear} clear");
    assert!(thick > 500 && clear > 3000, "too little of each: {thick}, {clear}");
    assert!(hidden * 100 > thick * 97, "{hidden} of {thick} directions under thick cloud look another way");
    assert!(changed * 200 < clear, "{changed} of {clear} directions under a clear sky look another way");
    assert!(elsewhere * 20 > clear, "a mirrored map would pass: {elsewhere} of {clear}");
}

#[test]
fn tiles_have_the_clouds_of_the_whole_picture() {
    let Some(context) = device() else { return };
    let mut sky = Sky::new(&context);
    let view = sky.view(DVec3::new(0.3, 0.5, 0.6).normalize() * (CLOUDS + 900.0), -12.0, 1.1);
    let cut = sky.scene.settle(&view).unwrap();
    let look = Look::daylight(view.eye.normalize());
    let draw = |tile| {
        let mut studio = Studio::new(&context, SIZE, StillOptions { tile, ..StillOptions::default() }).unwrap();
        match studio.draw(&sky.scene, &view, &cut, &look, &|_, _| ()).unwrap().pixels {
            Pixels::Eight(pixels) => pixels,
            _ => unreachable!("eight bits were asked for"),
        }
    };
    let (whole, tiled) = (draw(256), draw(64));
    let largest = whole.iter().zip(&tiled).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(largest <= Some(1), "{largest:?} steps");
}

#[test]
fn clouds_are_absent_from_diagrams() {
    let Some(context) = device() else { return };
    let mut sky = Sky::new(&context);
    let [cloudy, bare] = [true, false].map(|clouds| sky.seen_from_afar(DVec3::X, Mode::Albedo, clouds).1);
    assert!(cloudy == bare, "clouds show in a diagram");
}
