//! Pictures from extreme positions: over poles, face edges and corners, inside a mountain, at the planet's centre, a million kilometres
//! away. Every pixel is finite, shows ground where a ray meets the ground, at the distance of the hit, and space is black.

use crate::harness::{device, pixel_ray, planet_file};
use glam::{DVec3, IVec3};
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::vulkan::Context;
use terrane_planet::draw::view::{Camera, View, NEAR};
use terrane_planet::globe::sphere::{direction, ONE};

const SIZE: [u32; 2] = [96, 64];
/// Vertical field of view in radians.
const FOV: f64 = 0.9;
/// Field of view in radians that the planet fills from a distance of [`AFAR`].
const TELEPHOTO: f64 = 8e-5;
/// A million kilometres, in metres.
const AFAR: f64 = 1e9;
/// Brightest channel of what is black: one step of dither.
const BLACK: u8 = 1;
/// Largest relative difference of distances that agree. Most pixels must agree, not all: the mesh is coarse in so small a picture.
const NEARLY: f64 = 0.05;

/// What a frame showed.
struct Shown {
    /// Distances of the ground along the view axis in metres; infinite where there is none.
    distances: Vec<f64>,
    /// The brightest channel.
    brightest: u8,
    /// Mean of all channels.
    mean: f64,
}

struct Studio {
    scene: Scene,
    /// All of the planet, for rays: what is drawn is only what is in sight.
    whole: Scene,
    headless: Headless,
}

impl Studio {
    fn new(context: &std::sync::Arc<Context>) -> Studio {
        let scene = Scene::open(context, planet_file(), SceneOptions::default()).unwrap();
        let whole = Scene::open(context, planet_file(), SceneOptions::whole_mesh()).unwrap();
        Studio { scene, whole, headless: Headless::new(context, (SIZE[0], SIZE[1])).unwrap() }
    }

    fn radius(&self) -> f64 {
        self.scene.planet().recipe.radius
    }

    /// A camera so many metres above the ground, or the sea, of a site.
    fn above(&self, site: DVec3, metres: f64, pitch: f64, fov: f64) -> Camera {
        // Above the ground that is known so far, and above that of finer patches.
        let known = self.whole.ground().height_at(site).unwrap();
        let surface = known.max(self.scene.planet().surface_height(site));
        Camera::looking(site * (self.radius() + surface + metres), 30.0, pitch, fov, SIZE)
    }

    fn highest_site(&self) -> DVec3 {
        let grid = |k: i32| DVec3::new(f64::from(k % 20) - 9.5, f64::from(k / 20 % 20) - 9.5, f64::from(k / 400) - 4.5);
        let height = |site: &DVec3| self.whole.ground().height_at(*site).unwrap();
        (0..4000).map(|k| grid(k).normalize()).max_by(|a, b| height(a).total_cmp(&height(b))).unwrap()
    }

    fn show(&mut self, camera: Camera, name: &str) -> Shown {
        let view = View::new(camera, self.scene.lattice(), self.scene.planet().cells, 1.0);
        let cut = self.scene.settle(&view).unwrap();
        self.whole.settle(&view).unwrap();
        let sun = sun_over(camera.position.normalize_or(DVec3::X), 135.0, 35.0);
        let look = Look::daylight(sun);
        self.headless.render(&self.scene, &view, &cut, &look).unwrap();
        assert!(self.headless.radiance().unwrap().iter().all(|x| x.is_finite()), "{name}: radiance that is no number");
        let depth = self.headless.depth().unwrap();
        assert!(depth.iter().all(|d| (0.0..=1.0).contains(d)), "{name}: impossible depths");
        let pixels = self.headless.pixels().unwrap();
        let channels = || pixels.chunks_exact(4).flat_map(|p| &p[..3]);
        Shown {
            distances: depth.into_iter().map(|d| f64::from(NEAR) / f64::from(d)).collect(),
            brightest: channels().copied().max().unwrap(),
            mean: channels().map(|&c| f64::from(c)).sum::<f64>() / channels().count() as f64,
        }
    }

    /// Three shares of pixels: those that show ground, those where picture and ray disagree on whether there is ground, and, of those with
    /// ground, those where picture and ray agree on its distance.
    fn agreement(&self, camera: &Camera, shown: &Shown) -> [f64; 3] {
        let (mut ground, mut wrong, mut near, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (k, &distance) in shown.distances.iter().enumerate().step_by(7) {
            let ray = pixel_ray(camera, k);
            let hit = self.whole.ground().known.raycast(camera.position, ray).map(|hit| hit.distance / ray.length());
            count += 1.0;
            ground += f64::from(u8::from(distance.is_finite()));
            wrong += f64::from(u8::from(hit.is_some() != distance.is_finite()));
            near += f64::from(u8::from(hit.is_some_and(|hit| (hit / distance - 1.0).abs() < NEARLY)));
        }
        [ground / count, wrong / count, if ground > 0.0 { near / ground } else { 1.0 }]
    }
}

/// Cameras that must see ground, by name.
fn cameras(studio: &Studio) -> Vec<(String, Camera)> {
    let corner = direction(IVec3::new(ONE, ONE, ONE));
    let edge = direction(IVec3::new(ONE, ONE, ONE / 7));
    let sites = [
        ("north pole", DVec3::Z),
        ("south pole", -DVec3::Z),
        ("face edge", edge),
        ("face corner", corner),
        ("opposite corner", -corner),
        ("mountain", studio.highest_site()),
    ];
    let mut all = Vec::new();
    for (name, site) in sites {
        for (metres, pitch, fov) in [(2.0, -30.0, FOV), (5e3, -40.0, FOV), (6e4, -90.0, FOV), (AFAR, -90.0, TELEPHOTO)] {
            all.push((format!("{metres} m above the {name}"), studio.above(site, metres, pitch, fov)));
        }
    }
    all
}

#[test]
fn pictures_from_extreme_sites_show_the_ground_where_it_is() {
    let Some(context) = device() else { return };
    let mut studio = Studio::new(&context);
    for (name, camera) in cameras(&studio) {
        let shown = studio.show(camera, &name);
        let [ground, wrong, near] = studio.agreement(&camera, &shown);
        assert!(ground > 0.2, "{name}: {ground} of the picture is ground");
        assert!(wrong < 0.03 && near > 0.9, "{name}: {wrong} wrongly ground or not, {near} as far away as it is");
        assert!(shown.mean > 8.0 && shown.brightest > 60, "{name}: mean {} up to {}", shown.mean, shown.brightest);
    }
}

#[test]
fn ground_that_is_elsewhere_is_noticed() {
    let Some(context) = device() else { return };
    let mut studio = Studio::new(&context);
    let cameras = cameras(&studio);
    let shown = studio.show(cameras[0].1, &cameras[0].0);
    for (_, other) in &cameras[1..4] {
        let [_, wrong, near] = studio.agreement(other, &shown);
        assert!(wrong > 0.03 || near < 0.9, "{wrong} {near}");
    }
}

#[test]
fn it_is_dark_in_the_ground() {
    let Some(context) = device() else { return };
    let mut studio = Studio::new(&context);
    let mountain = studio.highest_site();
    let mut cameras: Vec<Camera> = [0.0, 90.0, -90.0].map(|pitch| studio.above(mountain, -100.0, pitch, FOV)).to_vec();
    let deep = [DVec3::ZERO, DVec3::splat(1e-7), DVec3::splat(8e3)];
    cameras.extend(deep.map(|position| Camera::looking(position, 0.0, 30.0, FOV, SIZE)));
    for camera in cameras {
        let shown = studio.show(camera, &format!("{camera:?}"));
        assert!(shown.brightest <= BLACK, "up to {} from {camera:?}", shown.brightest);
    }
}

#[test]
fn space_is_black() {
    let Some(context) = device() else { return };
    let mut studio = Studio::new(&context);
    let site = DVec3::new(0.6, 0.48, 0.64);
    // Away from the planet, and towards it from where it is far smaller than a pixel.
    for pitch in [90.0, -90.0] {
        let shown = studio.show(studio.above(site, AFAR, pitch, FOV), "space");
        assert!(shown.mean < 0.1, "mean {}", shown.mean);
    }
    // Beside the planet.
    let camera = studio.above(site, AFAR, -90.0, 4.0 * TELEPHOTO);
    let shown = studio.show(camera, "beside");
    let [ground, wrong, _] = studio.agreement(&camera, &shown);
    assert!((0.005..0.1).contains(&ground) && wrong < 0.01, "{ground} is ground, {wrong} wrongly");
    assert!(shown.mean < 12.0, "mean {}", shown.mean);
}
