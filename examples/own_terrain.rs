//! A planet of your own terrain: two functions of direction, through the bake into a planet file.
//!
//! `cargo run --release --example own_terrain -- [OUT.planet]`, and then `terrane shot OUT.planet --stored-only --out moon.png`

use glam::DVec3;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::{Elevation, GroundColour, GroundPoint};
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::store::{PlanetFile, PlanetHeader};

/// Radius of the datum in metres.
const RADIUS: f64 = 200_000.0;

/// Highest ground above the datum, and lowest below it, in metres.
const AMPLITUDE: f64 = 3_000.0;

/// What the file says of its planet: a recipe with the radius and the light, and without layers, since the ground is ours.
const RECIPE: &str = "
name = \"Eggs\"
radius_m = 200000.0
seed = 1

[palette]
kind = \"airless\"
";

/// An egg box: bumps along three axes. Only `+ - * /` and `sqrt`, so that every machine builds the same bytes.
struct EggBox;

impl EggBox {
    fn height(direction: DVec3) -> f64 {
        // A smooth wave from -1 to 1 with a period of 1.
        let wave = |x: f64| {
            let x = 2.0 * (x - (x + 0.5).floor());
            4.0 * x * (1.0 - x.abs())
        };
        let p = direction * 9.0;
        AMPLITUDE / 3.0 * (wave(p.x) + wave(p.y) + wave(p.z))
    }
}

impl Elevation for EggBox {
    fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        for (height, &direction) in heights.iter_mut().zip(directions) {
            *height = EggBox::height(direction);
        }
    }
}

impl GroundColour for EggBox {
    fn albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        for (colour, point) in albedo.iter_mut().zip(points) {
            let steep = point.slope.min(1.0);
            *colour = [200.0 - 90.0 * steep, 180.0 - 100.0 * steep, 150.0 - 100.0 * steep].map(|channel: f64| channel as u8);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("terrane-own.planet"), PathBuf::from);
    let header = PlanetHeader {
        name: "Eggs".into(),
        recipe: RECIPE.into(),
        assets: Vec::new(),
        cells: 64,
        lattice: Lattice::new(RADIUS, 0.0),
        height_range: [-AMPLITUDE, AMPLITUDE],
    };
    let mut file = PlanetFile::create_or_resume(&out, &header)?;
    let plan = BakePlan::new(RADIUS, 2, None)?;
    let summary = bake(&mut file, &EggBox, &EggBox, &plan, 2, &|_| {}, &AtomicBool::new(false))?;
    println!("{}: {} patches built, {} there before", out.display(), summary.built, summary.skipped);

    let mesh = file.mesh(PatchId::containing(DVec3::X, 2))?;
    println!("patch {}: {} vertices, {:?} lattice units high", mesh.id, mesh.vertices.len(), mesh.facts.heights);
    Ok(())
}
