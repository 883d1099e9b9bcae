//! Heights and rays on the CPU, without a planet file and without a GPU.
//!
//! `cargo run --release --example heights -- [LATITUDE LONGITUDE]`

use std::sync::{Arc, RwLock};
use std::time::Duration;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::query::{KnownGround, PatchGrid, Refiner};
use terrane_planet::recipe::shipped;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let degrees: Vec<f64> = std::env::args().skip(1).map(|word| word.parse()).collect::<Result<_, _>>()?;
    let (latitude, longitude) = (degrees.first().copied().unwrap_or(20.0), degrees.get(1).copied().unwrap_or(30.0));
    let planet = Arc::new(Planet::from_recipe(shipped::load("terra")?, 128)?);
    let direction = direction_at(latitude, longitude);

    // The terrain function itself: exact, and a few microseconds a direction.
    println!("terrain function  {:10.3} m", planet.terrain.height(direction));

    // What is drawn: the triangles of the finest patches that are known. First the six faces of the cube …
    let mut known = KnownGround::new(planet.lattice, planet.cells);
    for id in PatchId::roots() {
        known.insert(PatchGrid::sample(&planet.ground(), id));
    }
    let known = Arc::new(RwLock::new(known));
    let height = || known.read().ok()?.height_at(direction);
    let coarse = height().ok_or("the whole planet is known")?;
    println!("six faces         {:10.3} m, from samples {:.0} m apart", coarse.height, coarse.spacing);

    // … then finer ones, which a thread makes known in the background until their samples are a metre apart.
    let refiner = Refiner::new(planet.clone(), known.clone());
    let refinement = refiner.refine(direction, 1.0);
    if !refinement.wait(Duration::from_secs(60)) {
        return Err("the ground was not refined within a minute".into());
    }
    let fine = height().ok_or("the whole planet is known")?;
    println!("refined           {:10.3} m, from samples {:.1} m apart", fine.height, fine.spacing);

    // A ray from 500 m above the ground, straight down.
    let eye = direction * (planet.recipe.radius + fine.height + 500.0);
    let hit = known.read().map_err(|_| "the ground was left in disorder")?.raycast(eye, -direction).ok_or("the ray misses")?;
    println!("a ray down        {:10.3} m, after {:.3} m, in patch {}", hit.height, hit.distance, hit.patch);
    Ok(())
}
