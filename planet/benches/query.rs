//! Ground truth on the CPU: heights and rays a second against the patches that a camera near the ground stands among, from level 0
//! down to samples 0.6 m apart.
//!
//! `cargo bench -p terrane-planet --bench query`

use criterion::{criterion_group, criterion_main, Criterion, Throughput};
use glam::DVec3;
use std::path::Path;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::random::Random;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::query::{KnownGround, PatchGrid};
use terrane_planet::recipe::Recipe;

/// Finest level known, and queries a batch.
const LEVEL: u8 = 17;
const QUERIES: usize = 1024;

/// The ground around a site, known to [`LEVEL`].
fn known(planet: &Planet, site: DVec3) -> KnownGround {
    let ground = planet.ground();
    let mut known = KnownGround::new(planet.lattice, planet.cells);
    let around = (0..LEVEL).filter_map(|level| PatchId::containing(site, level).children()).flatten();
    for id in PatchId::roots().chain(around) {
        known.insert(PatchGrid::sample(&ground, id));
    }
    known
}

fn queries(c: &mut Criterion) {
    let recipe = Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/terra.toml")).expect("a shipped recipe");
    let planet = Planet::from_recipe(recipe, 128).expect("a shipped recipe");
    let site = direction_at(36.62, 106.05);
    let known = known(&planet, site);
    let radius = planet.recipe.radius;
    let mut random = Random::new(1);
    let mut aside = |metres: f64| DVec3::from_array(std::array::from_fn(|_| random.range(-metres, metres))) / radius;
    let near: Vec<DVec3> = (0..QUERIES).map(|_| (site + aside(40.0)).normalize()).collect();
    let anywhere: Vec<DVec3> = (0..QUERIES).map(|_| (aside(radius)).normalize()).collect();
    let eye = planet.position_above(site, 50.0);
    let sights: Vec<DVec3> = (0..QUERIES).map(|_| (aside(radius) - 0.5 * site).normalize()).collect();

    let mut group = c.benchmark_group("ground");
    group.throughput(Throughput::Elements(QUERIES as u64));
    for (name, directions) in [("height_at near", &near), ("height_at anywhere", &anywhere)] {
        group.bench_function(name, |b| {
            b.iter(|| directions.iter().filter_map(|&d| known.height_at(d)).map(|g| g.height).sum::<f64>())
        });
    }
    group.bench_function("raycast from 50 m", |b| {
        b.iter(|| sights.iter().filter(|&&ray| known.raycast(eye, ray).is_some()).count())
    });
    let mut heights = vec![0.0; QUERIES];
    group.bench_function("terrain function, no patches", |b| b.iter(|| planet.terrain.heights(&near, &mut heights)));
    group.finish();
}

criterion_group!(benches, queries);
criterion_main!(benches);
