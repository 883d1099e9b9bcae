//! Simplification of plain heightfields against what else there is: greedy insertion (`delatin`, after Garland and Heckbert 1995)
//! and quadric collapses (`meshopt`). In: fractal and ridged fields, made here. Out: timings, and a Markdown table of errors, all
//! measured alike by `TriangleSurface::deviation`.
//!
//! `cargo bench -p terrane-heightfield --bench simplify` runs both; with `quality` only the table, with `timing` only the timings.

use criterion::{BenchmarkId, Criterion, Throughput};
use std::hint::black_box;
use std::time::{Duration, Instant};
use terrane_heightfield::plain::{simplify, HalfEdgeCollapses};
use terrane_heightfield::{Deviation, Heightfield, TriangleSurface};

/// Shares of the faces of the full grid that surfaces are compared at.
const SHARES: [f64; 3] = [0.2, 0.05, 0.01];

/// Bisections of the error that greedy insertion needs for a number of faces.
const BISECTIONS: usize = 10;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let wants = |what: &str| arguments.iter().any(|a| a == what);
    let test = wants("--test");
    if test {
        // Only that everything runs.
        quality(&[33], 1);
    } else if !wants("timing") {
        quality(&[257, 1025], 3);
    }
    if !wants("quality") {
        let mut criterion = Criterion::default().warm_up_time(Duration::from_secs(1)).sample_size(10).configure_from_args();
        timing(&mut criterion, if test { &[33] } else { &[65, 129, 257, 513, 1025] });
        criterion.final_summary();
    }
}

fn timing(criterion: &mut Criterion, sides: &[usize]) {
    let mut group = criterion.benchmark_group("timing");
    for &side in sides {
        let field = make_field(side, false, 1);
        let full = 2 * (side - 1) * (side - 1);
        let target = full / 20;
        let collapses = simplify(&field).expect("finite heights");
        let grid = collapses.surface(&field, 0);
        let largest = collapses.polished(&field, target).deviation(&field).max;
        group.throughput(Throughput::Elements(full as u64));
        group.bench_function(BenchmarkId::new("simplify", side), |b| b.iter(|| simplify(black_box(&field))));
        group.bench_function(BenchmarkId::new("polish", side), |b| b.iter(|| collapses.polished(black_box(&field), target)));
        group.bench_function(BenchmarkId::new("meshopt", side), |b| b.iter(|| quadrics(black_box(&grid), target)));
        group.bench_function(BenchmarkId::new("greedy", side), |b| b.iter(|| greedy_within(black_box(&field), 1.6 * largest)));
    }
    group.finish();
}

/// Prints errors and their ratios.
fn quality(sides: &[usize], seeds: u64) {
    println!("| field | faces | raw max / RMS | polished max / RMS | greedy max / RMS | meshopt max / RMS | polished : raw | : greedy | : meshopt | RMS : meshopt | simplify, polish s |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for &side in sides {
        for (ridged, seed) in (1..=seeds).flat_map(|seed| [(false, seed), (true, seed)]) {
            let field = make_field(side, ridged, seed);
            let start = Instant::now();
            let collapses = simplify(&field).expect("finite heights");
            let simplified = start.elapsed().as_secs_f64();
            for share in SHARES {
                let name = format!("{side}² {} {seed}", if ridged { "ridged" } else { "fractal" });
                print_row(&name, &field, &collapses, share, simplified);
            }
        }
    }
}

fn print_row(name: &str, field: &Heightfield, collapses: &HalfEdgeCollapses, share: f64, simplified: f64) {
    let faces = (collapses.most_faces() as f64 * share) as usize;
    let start = Instant::now();
    let polished = collapses.polished(field, faces);
    let seconds = start.elapsed().as_secs_f64();
    let raw = collapses.surface(field, collapses.collapses_to(faces));
    let greedy = greedy(field, faces, raw.deviation(field).max);
    let quadrics = quadrics(&collapses.surface(field, 0), faces);
    let [raw, ours, greedy, quadrics] = [raw, polished, greedy, quadrics].map(|surface| surface.deviation(field));
    let pair = |d: Deviation| format!("{:.3} / {:.3}", d.max, d.rms);
    println!(
        "| {name} | {share} | {} | {} | {} | {} | {:.3} | {:.3} | {:.3} | {:.3} | {simplified:.2}, {seconds:.2} |",
        pair(raw),
        pair(ours),
        pair(greedy),
        pair(quadrics),
        ours.max / raw.max,
        ours.max / greedy.max,
        ours.max / quadrics.max,
        ours.rms / quadrics.rms
    );
}

/// Greedy insertion to a number of faces, with a largest error from `low` to twice that.
fn greedy(field: &Heightfield, faces: usize, low: f64) -> TriangleSurface {
    let (mut low, mut high) = (low, 2.0 * low);
    let mut best = TriangleSurface::default();
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let surface = greedy_within(field, middle);
        if surface.faces.len() <= faces {
            (best, high) = (surface, middle);
        } else {
            low = middle;
        }
    }
    best
}

/// Greedy insertion to a largest error.
fn greedy_within(field: &Heightfield, error: f64) -> TriangleSurface {
    let heights: Vec<f64> = field.heights().iter().map(|&h| f64::from(h)).collect();
    let size = (field.columns(), field.rows());
    let (vertices, faces) = delatin::triangulate(&heights, size, delatin::Error(error)).expect("a grid of finite heights");
    let sample = |&(column, row): &(usize, usize)| row * field.columns() + column;
    TriangleSurface {
        positions: vertices.iter().map(|v| field.position(sample(v))).collect(),
        faces: faces.iter().map(|&(a, b, c)| [a as u32, c as u32, b as u32]).collect(),
    }
}

/// Quadric collapses to a number of faces.
fn quadrics(grid: &TriangleSurface, faces: usize) -> TriangleSurface {
    let positions: Vec<[f32; 3]> = grid.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let adapter = meshopt::VertexDataAdapter::new(bytemuck::cast_slice(&positions), 12, 0).expect("packed positions");
    let indices = meshopt::simplify(grid.faces.as_flattened(), &adapter, 3 * faces, 1e9, meshopt::SimplifyOptions::None, None);
    let faces = indices.as_chunks::<3>().0.to_vec();
    TriangleSurface { positions: grid.positions.clone(), faces }
}

/// Eight octaves of gradient noise, each half as long and high as the one before; with `ridged` folded at zero.
fn make_field(side: usize, ridged: bool, seed: u64) -> Heightfield {
    let height = |x: f64, y: f64| {
        let (mut sum, mut length, mut size) = (0.0, side as f64 / 2.0, 50.0);
        for octave in 0..8 {
            if length >= 2.0 {
                let noise = gradient_noise(x / length + 3.3, y / length + 1.7, seed * 100 + octave);
                sum += size * if ridged { 1.0 - 2.0 * noise.abs() } else { noise };
            }
            (length, size) = (0.5 * length, 0.5 * size);
        }
        sum as f32
    };
    let samples = (0..side * side).map(|k| height((k % side) as f64, (k / side) as f64));
    Heightfield::new(side, side, samples.collect()).expect("as many samples as the square has")
}

fn gradient_noise(x: f64, y: f64, seed: u64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let [u, v] = [x - column, y - row].map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let at = |dx: f64, dy: f64| {
        let (i, j) = (column + dx, row + dy);
        hash(i, j, seed) * (x - i) + hash(i, j, seed + 77) * (y - j)
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    1.5 * mix(mix(at(0.0, 0.0), at(1.0, 0.0), u), mix(at(0.0, 1.0), at(1.0, 1.0), u), v)
}

/// A number from -1 to 1 for a lattice point.
fn hash(column: f64, row: f64, seed: u64) -> f64 {
    let mut h = (column as i64 as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (row as i64 as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    h = (h ^ (h >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 32)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((h ^ (h >> 29)) >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
}
