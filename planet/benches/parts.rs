//! What the parts of one patch cost, and of its horizon map, at the grid that is shipped: milliseconds on one core, the best of some
//! runs, on average over sites and levels. Prints Markdown.
//!
//! `cargo bench -p terrane-planet --bench parts`; `-- 128` for another grid; with `RUSTFLAGS="--cfg terrane_no_avx512"` as on machines without
//! AVX-512.

mod common;

use common::{grid_of, patches, LEVELS};
use std::hint::black_box;
use std::time::Instant;
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::ground::horizon::HorizonMap;
use terrane_planet::ground::surroundings::{KnownSurroundings, Surroundings};
use terrane_planet::ground::texture::PatchTexture;
use terrane_planet::ground::{Ground, HeightGrid, KeptHeights};
use terrane_planet::mesh::border::BorderLine;
use terrane_planet::mesh::border_rules::BorderRules;
use terrane_planet::mesh::build_patch;
use terrane_planet::mesh::builder::build;
use terrane_planet::mesh::certificate::KAPPA_BUILD;
use terrane_planet::mesh::surface::Surface;
use terrane_planet::planet::Planet;

/// Best of so many.
const RUNS: usize = 7;

const PARTS: [&str; 9] =
    ["heights", "surface", "border rules", "child wake", "collapses", "texture", "whole patch", "surroundings", "horizon map"];

/// Milliseconds of the best run of a part of a patch; what it takes is prepared by `given`, which does not count.
fn best_of<G, T>(mut given: impl FnMut() -> G, mut work: impl FnMut(G) -> T) -> f64 {
    let mut time = || {
        let given = given();
        let start = Instant::now();
        black_box(work(given));
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..RUNS).map(|_| time()).fold(f64::INFINITY, f64::min)
}

/// A planet's ground with these heights kept.
fn beside<'a>(planet: &'a Planet, kept: Option<&'a KeptHeights>) -> Ground<'a> {
    Ground { kept, ..planet.ground() }
}

/// With the parent's heights kept or without.
fn parts(planet: &Planet, id: PatchId, beside_parent: bool) -> [f64; PARTS.len()] {
    let kept = || {
        let kept = KeptHeights::new(planet.cells);
        if let Some(parent) = id.parent().filter(|_| beside_parent) {
            kept.keep(&HeightGrid::sample(&planet.ground(), parent));
        }
        kept
    };
    let first = kept();
    let grid = HeightGrid::sample(&beside(planet, Some(&first)), id);
    let ground = beside(planet, None);
    let surface = Surface::new(&ground, &grid);
    let rules = || BorderRules::new(&ground, &grid, KAPPA_BUILD);
    let child_wake = |()| Side::ALL.map(|side| BorderLine::of_side(id, side).child_wake(&ground, &grid, id.level, KAPPA_BUILD));
    let sun = direction_at(5.0, 60.0);
    let beside_own = || {
        let kept = kept();
        if beside_parent {
            kept.keep(&grid);
        }
        kept
    };
    let known = KnownSurroundings::default();
    [
        best_of(kept, |kept| HeightGrid::sample(&beside(planet, Some(&kept)), id)),
        best_of(|| (), |()| Surface::new(&ground, &grid)),
        best_of(|| (), |()| rules()),
        best_of(|| (), child_wake),
        best_of(rules, |rules| build(&surface, rules, KAPPA_BUILD)),
        best_of(|| (), |()| PatchTexture::new(&ground, &planet.terrain, id, &grid)),
        best_of(kept, |kept| build_patch(&beside(planet, Some(&kept)), &planet.terrain, id)),
        best_of(beside_own, |kept| Surroundings::sample(&beside(planet, Some(&kept)), id)),
        best_of(|| (), |()| HorizonMap::new(&ground, id, sun, &mut known.sampled(&ground))),
    ]
}

fn main() {
    let cells = std::env::args().filter_map(|arg| arg.parse().ok()).next().unwrap_or(64);
    println!("| {cells} cells | {} |\n|---|{}", PARTS.join(" | "), "---|".repeat(PARTS.len()));
    for (name, beside_parent) in ["terra", "luna", "mars"].into_iter().flat_map(|name| [(name, false), (name, true)]) {
        let planet = grid_of(name, cells);
        let ids: Vec<PatchId> = LEVELS.into_iter().flat_map(|level| patches(level).take(2)).map(|(_, id)| id).collect();
        let sums = ids.iter().fold([0.0; PARTS.len()], |sums, &id| {
            let times = parts(&planet, id, beside_parent);
            std::array::from_fn(|k| sums[k] + times[k] / ids.len() as f64)
        });
        let given = if beside_parent { ", parent known" } else { "" };
        println!("| {name}{given} | {} |", sums.map(|ms| format!("{ms:.2}")).join(" | "));
    }
}
