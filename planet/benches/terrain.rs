//! Samples of the terrain function a second, on the height samples of real patches: `cargo bench -p terrane-planet --bench
//! terrain`.

mod common;

use common::{patches, planet, LEVELS};
use criterion::{criterion_group, criterion_main, Criterion, Throughput};
use terrane_planet::ground::{Ground, HeightGrid};

fn heights(criterion: &mut Criterion) {
    for name in ["terra", "luna", "mars"] {
        let planet = planet(name);
        let ground = Ground { kept: None, ..planet.ground() };
        let mut group = criterion.benchmark_group(name);
        for (level, (site, id)) in LEVELS.into_iter().flat_map(|level| patches(level).map(move |patch| (level, patch))) {
            let side = u64::from(2 * planet.cells + 9);
            group.throughput(Throughput::Elements(side * side));
            group.bench_function(format!("level {level}, {site}"), |b| b.iter(|| HeightGrid::sample(&ground, id)));
        }
    }
}

criterion_group!(benches, heights);
criterion_main!(benches);
