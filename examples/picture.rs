//! A picture without a window: bakes two levels of a small planet, opens the file, and draws it as a PNG.
//!
//! `cargo run --release --example picture -- [OUT.png]`

use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use terrane::frame::{sun_over, Look};
use terrane::scene::{OnDemand, Scene, SceneOptions};
use terrane::stills::{StillOptions, Studio};
use terrane::vulkan::{Context, ContextOptions};
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::Stand;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;
use terrane_planet::store::PlanetFile;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("terrane-picture.png"), PathBuf::from);
    let path = out.with_extension("planet");

    // A planet file: levels 0 and 1 of the whole planet. A second run finds them there and builds nothing.
    let planet = Planet::from_recipe(shipped::load("tiny")?, 128)?;
    let mut file = PlanetFile::create_or_resume(&path, &planet.header())?;
    let plan = BakePlan::new(planet.recipe.radius, 1, None)?;
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| {}, &AtomicBool::new(false))?;

    // The file on a GPU. What the view needs beyond the file is built on the way, down to samples 4 m apart, and not kept.
    let context = Context::new(&ContextOptions::default())?;
    let on_demand = Some(OnDemand { spacing_m: 4.0, cache: None });
    let mut scene = Scene::open(&context, &path, SceneOptions { on_demand, ..SceneOptions::default() })?;

    // A view: 3 km above the ground, looking north-east, with an error of at most one pixel.
    let (latitude, longitude) = (20.0, 30.0);
    let keyframe =
        Keyframe { time_s: 0.0, latitude, longitude, stand: Stand::Altitude(3000.0), heading: 45.0, pitch: -20.0, fov: 50.0 };
    let camera = scene.planet().camera_at(&keyframe, [640, 360]);
    let view = View::new(camera, scene.lattice(), scene.planet().cells, 1.0);
    let look = Look::daylight(sun_over(direction_at(latitude, longitude), 135.0, 35.0));
    scene.set_sun(look.sun);

    // Settling reads and builds until nothing is missing. Then the picture is a function of the view alone.
    let cut = scene.settle(&view)?;
    let mut studio = Studio::new(&context, camera.size, StillOptions::default())?;
    let still = studio.draw(&scene, &view, &cut, &look, &|_, _| {})?;
    still.write_png(File::create(&out)?)?;
    println!("{}: {} patches, {} triangles", out.display(), still.report.tables.patches.len(), still.report.counters.wanted);
    Ok(())
}
