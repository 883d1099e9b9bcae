//! A planet file at the other end of a line: a whole, coarse picture comes soon, no later one has a hole, and the last is the one from a
//! file at hand.

use crate::harness::{cloudy_planet_file, device, planet_file};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::measure::live::holes;
use terrane::scene::{OnDemand, Scene, SceneOptions, Scope};
use terrane::stills::{Pixels, StillOptions, Studio};
use terrane::vulkan::Context;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::planet::Planet;
use terrane_planet::store::slow::Delay;

const SIZE: [u32; 2] = [160, 90];

const DELAY: Delay = Delay { latency: Duration::from_millis(20), bytes_per_second: 1e6 };

fn view(planet: &Planet, direction: DVec3, altitude: f64, pitch: f64) -> View {
    let position = planet.position_above(direction.normalize(), altitude);
    View::new(Camera::looking(position, 30.0, pitch, 0.9, SIZE), &planet.lattice, planet.cells, 1.0)
}

/// The settled picture of a view, and how many patches were read for it.
fn picture(context: &Arc<Context>, scene: &mut Scene, view: &View) -> (Vec<u8>, u64) {
    let look = look(view);
    scene.set_sun(look.sun);
    let cut = scene.settle(view).unwrap();
    let mut studio = Studio::new(context, SIZE, StillOptions::default()).unwrap();
    let still = studio.draw(scene, view, &cut, &look, &|_, _| ()).unwrap();
    let Pixels::Eight(pixels) = still.pixels else { panic!("pixels of eight bits were asked for") };
    (pixels, scene.tally().read)
}

fn look(view: &View) -> Look {
    Look::daylight(sun_over(view.camera.position.normalize(), 120.0, 30.0))
}

fn over_the_line(context: &Arc<Context>, file: &Path, on_demand: Option<OnDemand>) -> Scene {
    Scene::open(context, file, SceneOptions { delay: Some(DELAY), on_demand, ..SceneOptions::default() }).unwrap()
}

/// Nothing finer than the finest patches of the file, and nothing kept.
fn nothing_finer(planet: &Planet) -> OnDemand {
    OnDemand { spacing_m: 1.01 * planet.lattice.unit * planet.lattice.sample_spacing(planet.cells, 5), cache: None }
}

#[test]
fn the_picture_over_a_line_is_the_picture_from_the_file_and_that_of_whole_meshes() {
    let Some(context) = device() else { return };
    let mut at_hand = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    for (direction, altitude, pitch) in [(DVec3::ONE, 400.0, -15.0), (DVec3::X, 60_000.0, -90.0)] {
        let view = view(at_hand.planet(), direction, altitude, pitch);
        let (expected, _) = picture(&context, &mut at_hand, &view);
        let mut far = over_the_line(&context, planet_file(), None);
        assert!(picture(&context, &mut far, &view).0 == expected, "from {altitude} m");
        // Stills read prefixes of meshes, flights all of them.
        let mut whole =
            Scene::open(&context, planet_file(), SceneOptions { scope: Scope::Flight, ..SceneOptions::default() }).unwrap();
        assert!(picture(&context, &mut whole, &view).0 == expected, "from {altitude} m, with whole meshes");
    }
}

#[test]
fn a_whole_picture_comes_first_and_no_later_one_has_a_hole() {
    let Some(context) = device() else { return };
    let at_hand = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    let planet = at_hand.shared_planet();
    let lowest = planet.recipe.radius + planet.terrain.height_range().0 - 200.0;
    let view = view(&planet, DVec3::ONE, 900.0, -20.0);
    let mut headless = Headless::new(&context, SIZE.into()).unwrap();
    let begun = Instant::now();
    let mut scene = over_the_line(&context, planet_file(), Some(nothing_finer(&planet)));
    scene.set_sun(look(&view).sun);
    let (mut first, mut pictures) = (None, 0);
    loop {
        let cut = scene.update(&view, usize::MAX).unwrap();
        let whole = scene.is_whole(&view, &cut);
        assert!(whole || first.is_none(), "a picture was whole, and is no longer");
        if whole {
            first.get_or_insert(begun.elapsed());
            headless.render(&scene, &view, &cut, &look(&view)).unwrap();
            assert_eq!(holes(&view.camera, &headless.depth().unwrap(), lowest), 0);
            pictures += 1;
        }
        if scene.is_settled() {
            break;
        }
    }
    let (first, settled) = (first.unwrap(), begun.elapsed());
    assert!(first < settled / 2 && pictures > 1, "{first:?} of {settled:?}, {pictures} pictures");
    let mut at_hand =
        Scene::open(&context, planet_file(), SceneOptions { on_demand: Some(nothing_finer(&planet)), ..SceneOptions::default() })
            .unwrap();
    assert!(picture(&context, &mut scene, &view).0 == picture(&context, &mut at_hand, &view).0);
}

#[test]
fn clouds_come_last_over_a_line() {
    let Some(context) = device() else { return };
    let mut at_hand = Scene::open(&context, cloudy_planet_file(), SceneOptions::default()).unwrap();
    let view = view(at_hand.planet(), DVec3::X, 90_000.0, -90.0);
    let expected = picture(&context, &mut at_hand, &view).0;
    let mut far = over_the_line(&context, cloudy_planet_file(), None);
    let cut = far.update(&view, usize::MAX).unwrap();
    let mut headless = Headless::new(&context, SIZE.into()).unwrap();
    if far.is_whole(&view, &cut) {
        headless.render(&far, &view, &cut, &look(&view)).unwrap();
    }
    assert!(picture(&context, &mut far, &view).0 == expected);
}
