//! Encoding and decoding of records, in vertices (geometry) and texels (textures) a second: `cargo bench -p terrane-planet
//! --bench record`. Prints the bytes a vertex and a texel take, and those of a mesh up to each chunk's end.

mod common;

use common::{patches, planet};
use criterion::{criterion_group, criterion_main, Criterion, Throughput};
use terrane_planet::store::geometry::{self, Head};
use terrane_planet::store::imagery;

fn records(criterion: &mut Criterion) {
    for name in ["terra", "luna", "tiny"] {
        let planet = planet(name);
        for level in [2, 10] {
            let Some((_, id)) = patches(level).next() else { continue };
            let (mesh, texture, _) = planet.build(id);
            let cells = planet.cells;
            let (Ok(shape), Ok(image)) = (geometry::encode(&mesh), imagery::encode(&texture, id, cells)) else {
                panic!("patch {id} of {name} cannot be encoded");
            };
            let (vertices, texels) = (mesh.vertices.len(), texture.albedo.len());
            println!("{name}, level {level}: {:.2} bytes a vertex", shape.len() as f64 / vertices as f64);
            println!("{name}, level {level}: {:.2} bytes a texel", image.len() as f64 / texels as f64);
            let head = Head::read(&shape, id, cells).expect("a record that was just encoded");
            for chunk in &head.chunks {
                println!("{name}, level {level}: {} vertices in {} bytes", chunk.end, chunk.bytes.end);
            }
            let mut group = criterion.benchmark_group(format!("{name}, level {level}"));
            group.throughput(Throughput::Elements(vertices as u64));
            group.bench_function("encode geometry", |b| b.iter(|| geometry::encode(&mesh)));
            group.bench_function("decode geometry", |b| b.iter(|| geometry::decode(&shape, id, cells)));
            for chunks in 1..head.chunks.len() {
                let decode = || geometry::decode_chunks(&head, &shape, id, cells, chunks);
                group.bench_function(format!("decode {} vertices", head.chunks[chunks - 1].end), |b| b.iter(decode));
            }
            group.throughput(Throughput::Elements(texels as u64));
            group.bench_function("encode texture", |b| b.iter(|| imagery::encode(&texture, id, cells)));
            group.bench_function("decode texture", |b| b.iter(|| imagery::decode(&image, id, cells)));
        }
    }
}

criterion_group!(benches, records);
criterion_main!(benches);
