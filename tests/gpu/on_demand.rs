//! Patches that no file holds: they are built on demand, equal baked ones, are cached for the next time, and stay within budgets.

use crate::harness::device;
use glam::DVec3;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::Arc;
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::scene::{CacheOptions, OnDemand, Scene, SceneOptions};
use terrane::vulkan::Context;
use terrane_planet::draw::layout::VERTEX_BITS;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::PlanetFile;

const FINEST: u8 = 3;

fn tiny() -> Planet {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("planet/recipes/tiny.toml");
    Planet::from_recipe(Recipe::load(&recipe).unwrap(), 16).unwrap()
}

/// A file with the whole planet to a level; `None` makes an empty one.
fn file(folder: &Path, planet: &Planet, levels: Option<u8>) -> std::path::PathBuf {
    let path = folder.join(format!("{levels:?}.planet"));
    let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
    if let Some(levels) = levels {
        let plan = BakePlan::new(planet.recipe.radius, levels, None).unwrap();
        bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    }
    path
}

fn building(planet: &Planet, cache: Option<u64>) -> SceneOptions {
    let cells = f64::from(planet.cells << FINEST);
    let spacing_m = 1.01 * std::f64::consts::FRAC_PI_2 * planet.recipe.radius / cells;
    assert_eq!(planet.level_of_spacing(spacing_m), FINEST);
    let cache = cache.map(|bytes| CacheOptions { bytes, side: None });
    SceneOptions { on_demand: Some(OnDemand { spacing_m, cache }), textures: false, ..SceneOptions::default() }
}

fn views(planet: &Planet) -> Vec<View> {
    let over = |direction: DVec3, altitude: f64, pitch: f64| {
        let position = planet.position_above(direction.normalize(), altitude);
        View::new(Camera::looking(position, 30.0, pitch, 0.9, [640, 360]), &planet.lattice, planet.cells, 1.0)
    };
    vec![over(DVec3::X, 60_000.0, -90.0), over(DVec3::ONE, 800.0, -10.0), over(DVec3::new(-1.0, 0.3, 0.2), 2000.0, -30.0)]
}

/// Everything that a view draws: triangles as patches and vertices, whatever their order.
fn drawn(context: &Arc<Context>, scene: &mut Scene, view: &View) -> BTreeSet<(PatchId, [u32; 3])> {
    let mut headless = Headless::new(context, (64, 64)).unwrap();
    let look = Look::daylight(DVec3::X);
    let cut = scene.settle(view).unwrap();
    assert!(scene.is_settled());
    let report = headless.select_whole(scene, view, &cut, &look).unwrap();
    let selection = headless.read_selection(&report).unwrap();
    let name = |t: &[u32; 3]| {
        let vertices = t.map(|v| v & ((1 << VERTEX_BITS) - 1));
        (report.tables.leaves[(t[0] >> VERTEX_BITS) as usize].id, vertices)
    };
    selection.triangles.iter().map(name).collect()
}

#[test]
fn patches_built_on_demand_equal_baked_ones() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let (baked, empty) = (file(folder.path(), &planet, Some(FINEST)), file(folder.path(), &planet, None));
    let stored = SceneOptions { textures: false, ..SceneOptions::default() };
    let mut from_file = Scene::open(&context, &baked, stored).unwrap();
    let expected: Vec<_> = views(&planet).iter().map(|view| drawn(&context, &mut from_file, view)).collect();
    let mut built = Scene::open(&context, &empty, building(&planet, Some(u64::MAX))).unwrap();
    // In reverse order, so that each view has other views before it.
    for (view, expected) in views(&planet).iter().zip(&expected).rev() {
        assert!(drawn(&context, &mut built, view) == *expected, "{:?}", view.camera);
    }
    let tally = built.tally();
    assert!(tally.built > 50 && tally.read == 0, "{tally:?}");
    drop(built);
    // A second scene reads all patches from the file.
    let mut again = Scene::open(&context, &empty, building(&planet, Some(u64::MAX))).unwrap();
    for (view, expected) in views(&planet).iter().zip(&expected) {
        assert!(drawn(&context, &mut again, view) == *expected, "{:?}", view.camera);
    }
    // A mesh is read again for a view that can wake more of it.
    assert!(again.tally().built == 0 && again.tally().read >= tally.built, "{:?}", again.tally());
}

#[test]
fn a_full_cache_keeps_the_picture() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let path = file(folder.path(), &planet, Some(0));
    let budget = 200_000;
    let mut scene = Scene::open(&context, &path, building(&planet, Some(budget))).unwrap();
    let first: Vec<_> = views(&planet).iter().map(|view| drawn(&context, &mut scene, view)).collect();
    drop(scene);
    let kept = PlanetFile::open(&path).unwrap();
    assert!((1..=budget).contains(&kept.cached_bytes().unwrap()), "{} bytes", kept.cached_bytes().unwrap());
    let mut again = Scene::open(&context, &path, building(&planet, Some(budget))).unwrap();
    for (view, first) in views(&planet).iter().zip(&first) {
        assert!(drawn(&context, &mut again, view) == *first);
    }
    assert!(again.tally().read > 0 && again.tally().built > 0, "{:?}", again.tally());
}

#[test]
fn a_small_gpu_budget_is_kept_by_a_coarser_picture() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let path = file(folder.path(), &planet, Some(0));
    let mut whole = Scene::open(&context, &path, building(&planet, None)).unwrap();
    let mut coarser = 0;
    for gpu_bytes in [0, 100_000, 400_000, 4_000_000] {
        let mut tight = Scene::open(&context, &path, SceneOptions { gpu_bytes, ..building(&planet, None) }).unwrap();
        for view in views(&planet) {
            let (coarse, fine) = (drawn(&context, &mut tight, &view), drawn(&context, &mut whole, &view));
            assert!(!coarse.is_empty() && coarse.len() <= fine.len(), "{} of {} triangles", coarse.len(), fine.len());
            coarser += usize::from(coarse.len() < fine.len());
            // A picture that fits loses nothing.
            assert!(coarse == fine || tight.is_limited(), "{} of {} triangles", coarse.len(), fine.len());
            let (used, most) = tight.gpu_bytes();
            assert!(used <= most, "{used} of {most} bytes");
        }
    }
    assert!(coarser >= 2, "{coarser} pictures are coarser");
}

#[test]
fn a_small_host_budget_is_kept_by_a_coarser_picture() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let path = file(folder.path(), &planet, Some(0));
    let mut whole = Scene::open(&context, &path, building(&planet, None)).unwrap();
    let mut coarser = 0;
    for host_bytes in [0, 1_000_000] {
        let mut tight = Scene::open(&context, &path, SceneOptions { host_bytes, ..building(&planet, None) }).unwrap();
        for view in views(&planet) {
            let (coarse, fine) = (drawn(&context, &mut tight, &view), drawn(&context, &mut whole, &view));
            assert!(!coarse.is_empty() && coarse.len() <= fine.len(), "{} of {} triangles", coarse.len(), fine.len());
            coarser += usize::from(coarse.len() < fine.len());
            let (used, most) = tight.host_bytes();
            assert!(used <= most, "{used} of {most} bytes");
            assert!(host_bytes == 0 || most <= host_bytes, "{most} bytes where {host_bytes} are allowed");
        }
    }
    assert!(coarser >= 1, "{coarser} pictures are coarser");
}
