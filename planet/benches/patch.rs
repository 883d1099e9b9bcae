//! What a patch built on demand costs, part by part: `cargo bench -p terrane-planet --bench patch`.

mod common;

use common::{patches, planet, LEVELS};
use criterion::{criterion_group, criterion_main, Criterion};
use terrane_planet::ground::texture::PatchTexture;
use terrane_planet::ground::{Ground, HeightGrid};
use terrane_planet::mesh::build_patch;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::store::BakedPatch;

fn parts(criterion: &mut Criterion) {
    for name in ["terra", "luna"] {
        let planet = planet(name);
        let ground = Ground { kept: None, ..planet.ground() };
        for (level, (site, id)) in LEVELS.into_iter().flat_map(|level| patches(level).take(2).map(move |patch| (level, patch))) {
            let mut group = criterion.benchmark_group(format!("{name}, level {level}, {site}"));
            group.sample_size(20);
            group.bench_function("heights", |b| b.iter(|| HeightGrid::sample(&ground, id)));
            let grid = HeightGrid::sample(&ground, id);
            group.bench_function("mesh", |b| b.iter(|| PatchMesh::build(&ground, &grid)));
            group.bench_function("textures", |b| b.iter(|| PatchTexture::new(&ground, &planet.terrain, id, &grid)));
            let (mesh, texture, _) = planet.build(id);
            group.bench_function("encode", |b| b.iter(|| BakedPatch::new(&mesh, &texture)));
            group.bench_function("whole", |b| b.iter(|| build_patch(&ground, &planet.terrain, id)));
        }
    }
}

criterion_group!(benches, parts);
criterion_main!(benches);
