//! Small planets to draw, on a device that must stay silent.

pub(crate) use crate::checked::{device, device_with};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::verify::Verifier;
use terrane::vulkan::Context;
use terrane_planet::draw::view::Camera;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::PlanetFile;
use terrane_planet::store::Region;

/// Bakes a recipe of the planet crate, with some text after it, into a temporary file.
fn baked(name: &str, more: &str, levels: u8, region: Option<Region>) -> (tempfile::TempDir, PathBuf) {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("planet/recipes/{name}.toml"));
    let text = std::fs::read_to_string(&recipe).unwrap() + more;
    let planet = Planet::from_recipe(Recipe::from_toml(&text, name, recipe.parent().unwrap()).unwrap(), 32).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{name}.planet"));
    let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, levels, region).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    (folder, path)
}

/// The tiny planet to level 1 with finer ground about a face corner, so that levels mix; baked once a process.
pub(crate) fn planet_file() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let region = Region { direction: DVec3::ONE.normalize(), radius_m: 500.0, to_level: 5 };
    &FILE.get_or_init(|| baked("tiny", "", 1, Some(region))).1
}

/// The coarsest level of the tiny planet under clouds; baked once a process.
pub(crate) fn cloudy_planet_file() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let clouds = "\n[clouds]\nheight_m = 1500.0\ncover = 0.5\n";
    &FILE.get_or_init(|| baked("tiny", clouds, 0, None)).1
}

/// The coarsest level of a planet of the Earth's size and air; baked once a process.
pub(crate) fn large_planet_file() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    &FILE.get_or_init(|| baked("terra", "", 0, None)).1
}

/// Ray through the centre of a pixel, its length per unit of distance along the view axis.
pub(crate) fn pixel_ray(camera: &Camera, pixel: usize) -> DVec3 {
    let [width, height] = camera.size;
    let (h, v) = camera.half_extents();
    let x = (2.0 * f64::from(pixel as u32 % width) + 1.0) / f64::from(width) - 1.0;
    let y = 1.0 - (2.0 * f64::from(pixel as u32 / width) + 1.0) / f64::from(height);
    camera.forward + camera.right() * (h * x) + camera.up * (v * y)
}

/// Everything that draws and checks the tiny planet.
pub(crate) struct Bench {
    pub(crate) scene: Scene,
    pub(crate) headless: Headless,
    pub(crate) verifier: Verifier,
}

impl Bench {
    pub(crate) fn new(context: &Arc<Context>) -> Bench {
        let scene = Scene::open(context, planet_file(), SceneOptions::whole_mesh()).unwrap();
        let verifier = Verifier::new(planet_file(), &scene).unwrap();
        Bench { scene, headless: Headless::new(context, (64, 64)).unwrap(), verifier }
    }
}
