//! A device that must stay silent, and a small planet to draw.

use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::verify::Verifier;
use terrane::vulkan::{Context, ContextOptions, MessageLog};
use terrane_planet::draw::view::Camera;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::PlanetFile;
use terrane_planet::store::Region;

/// One device at a time: several software devices at once only slow each other down.
static DEVICE: Mutex<()> = Mutex::new(());

/// A context that fails the test if validation has said anything by the time it is dropped.
pub(crate) struct Checked {
    context: Option<Arc<Context>>,
    log: Arc<MessageLog>,
    _device: MutexGuard<'static, ()>,
}

impl std::ops::Deref for Checked {
    type Target = Arc<Context>;

    fn deref(&self) -> &Arc<Context> {
        self.context.as_ref().expect("the context is dropped last")
    }
}

impl Drop for Checked {
    fn drop(&mut self) {
        // Destruction is validated too.
        self.context = None;
        let messages = self.log.take();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

/// The device to test on; none prints "skipped", or fails where `TERRANE_REQUIRE_GPU=1`.
pub(crate) fn device() -> Option<Checked> {
    device_with(None)
}

/// The device, drawing with so many samples a pixel.
pub(crate) fn device_with(samples: Option<u32>) -> Option<Checked> {
    let guard = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    match Context::new(&ContextOptions { validation: true, samples, ..ContextOptions::default() }) {
        Ok(context) => Some(Checked { log: context.message_log(), context: Some(context), _device: guard }),
        Err(error) => {
            let required = std::env::var("TERRANE_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "no device: {error}");
            println!("skipped: {error}");
            None
        }
    }
}

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
