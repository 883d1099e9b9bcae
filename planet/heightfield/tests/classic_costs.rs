//! Whole progressive meshes by cost: coverage, closure, determinism and quality.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use proptest::prelude::*;
use terrane_heightfield::classic::{euler_characteristic, progressive_mesh, ClassicError, Cost, ProgressiveMesh};
use terrane_heightfield::Heightfield;

fn field(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Heightfield {
    let heights = (0..columns * rows).map(|i| height((i % columns) as f64, (i / columns) as f64) as f32).collect();
    Heightfield::new(columns, rows, heights).unwrap()
}

/// A ridge and a round hill.
fn hills(columns: usize, rows: usize) -> Heightfield {
    field(columns, rows, |x, y| {
        let (ridge, hill) = ((x + y - 30.0) / 4.0, ((x - 12.0) / 5.0, (y - 25.0) / 5.0));
        6.0 / (1.0 + ridge * ridge) + 4.0 / (1.0 + hill.0 * hill.0 + hill.1 * hill.1)
    })
}

fn mesh(field: &Heightfield, cost: Cost) -> ProgressiveMesh {
    progressive_mesh(field, cost, &mut |_| ()).unwrap()
}

/// Every mesh is valid and covers the whole rectangle without turning over.
fn check_all_meshes(field: &Heightfield, cost: Cost) {
    let mut progressive = mesh(field, cost);
    assert_eq!(progressive.faces(), 2, "{cost:?} gets down to the corners");
    let area = ((field.columns() - 1) * (field.rows() - 1)) as f64;
    loop {
        let mesh = progressive.mesh();
        assert_eq!((mesh.validate(), euler_characteristic(mesh)), (Ok(()), 1));
        let areas: Vec<f64> = mesh
            .faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|v| mesh.positions[v as usize].truncate());
                (b - a).perp_dot(c - a) / 2.0
            })
            .collect();
        assert!(areas.iter().all(|&a| a > 0.0), "{cost:?}: a triangle turned over");
        assert!((areas.iter().sum::<f64>() - area).abs() < 1e-9 * area);
        assert_eq!(mesh.surface().deviation(field).uncovered, 0);
        if !progressive.next() {
            break;
        }
    }
    assert_eq!(progressive.mesh().surface().deviation(field).max, 0.0, "{cost:?} comes back to every sample");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn every_mesh_of_every_cost_covers_the_rectangle(columns in 2usize..12, rows in 2usize..12, seed: u32) {
        let rough = field(columns, rows, |x, y| {
            let hash = (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663) ^ seed;
            f64::from(hash.wrapping_mul(2_654_435_761) >> 16) / 16384.0
        });
        Cost::ALL.into_iter().for_each(|cost| check_all_meshes(&rough, cost));
    }
}

#[test]
fn level_ground_and_planes_go_down_to_the_corners_without_error() {
    for slope in [0.0, 0.7] {
        let plane = field(12, 9, |x, y| slope * x - 2.0 * slope * y);
        for cost in Cost::ALL {
            check_all_meshes(&plane, cost);
            assert!(mesh(&plane, cost).mesh().surface().deviation(&plane).max < 1e-5, "{cost:?}");
        }
    }
}

#[test]
fn costs_choose_far_better_than_the_grid_they_start_from() {
    let hills = hills(41, 41);
    // Every fourth sample: 200 faces.
    let coarse = field(11, 11, |x, y| f64::from(hills.at(4 * x as usize, 4 * y as usize)));
    let mut sparse = terrane_heightfield::classic::FaceMesh::from_heightfield(&coarse).surface();
    sparse.positions.iter_mut().for_each(|p| (p.x, p.y) = (4.0 * p.x, 4.0 * p.y));
    let grid = sparse.deviation(&hills);
    for cost in Cost::ALL {
        let mut progressive = mesh(&hills, cost);
        progressive.set_faces(200);
        let chosen = progressive.mesh().surface().deviation(&hills);
        let share = if cost == Cost::Spring { 0.7 } else { 0.3 };
        assert!(chosen.rms < share * grid.rms, "{cost:?}: {chosen:?}, grid {grid:?}");
    }
}

#[test]
fn replayed_collapses_give_the_surfaces_of_the_simplifier_that_made_them() {
    let hills = hills(23, 17);
    let collapses = terrane_heightfield::plain::simplify(&hills).unwrap();
    let mut progressive = mesh(&hills, Cost::Certified);
    for faces in [2, 30, 100, 400, 703] {
        let surface = collapses.surface(&hills, collapses.collapses_to(faces));
        assert_eq!(progressive.set_faces(faces), surface.faces.len());
        let (own, made) = (progressive.mesh().surface().deviation(&hills), surface.deviation(&hills));
        assert_eq!((own.max, own.uncovered), (made.max, made.uncovered));
        assert!((own.rms - made.rms).abs() <= 1e-12 * made.rms);
    }
}

#[test]
fn equal_fields_give_equal_meshes() {
    let hills = hills(20, 20);
    for cost in Cost::ALL {
        assert_eq!(mesh(&hills, cost), mesh(&hills, cost));
    }
}

#[test]
fn fields_with_gaps_are_refused_with_the_sample_and_what_to_do() {
    let mut heights = hills(5, 5).heights().to_vec();
    heights[13] = f32::NAN;
    heights[14] = f32::INFINITY;
    let gappy = Heightfield::new(5, 5, heights).unwrap();
    let error = progressive_mesh(&gappy, Cost::Spring, &mut |_| ()).unwrap_err();
    assert_eq!(error, ClassicError::Gaps { count: 2, column: 3, row: 2 });
    assert!(error.to_string().contains("fill the gaps"));
}
