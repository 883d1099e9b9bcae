//! The certificate, measured with rays: what is drawn stays within the tolerance of the finest resident surface.

mod common;
#[path = "common/whole_planet.rs"]
mod whole_planet;

use common::TestField;
use std::collections::HashMap;
use terrane_planet::layout::PatchVertex;
use terrane_planet::patch::PatchId;
use terrane_planet::progressive::PatchMesh;
use terrane_planet::reference::cut::{cut, cut_by, distance_to_box, urgency, Cut};
use terrane_planet::reference::{emit::emit, resolve::resolve, select::select};
use terrane_planet::verify::{measure, Drawn, Effort, FinestSurface, GridCache, Probe, ScreenError};
use terrane_planet::view::View;
use whole_planet::{planet, views, Planet};

const EFFORT: Effort = Effort { pixels: 1024, finer_samples: 4096, seed: 11 };

const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };

type Change<'a> = &'a dyn Fn(&Planet, PatchId, &mut Vec<PatchVertex>);

/// Measures a cut whose vertices were changed first.
fn error_of(planet: &Planet, view: &View, cut: &Cut, resident: &dyn Fn(PatchId) -> bool, change: Change) -> ScreenError {
    let mut patches = Vec::new();
    for leaf in &cut.leaves {
        let (patch, _) = &planet.patches[&leaf.id];
        let level = patch.reach.level_for(distance_to_box(view, &patch.mesh.bounds), view.scale);
        let mut vertices = patch.vertices.clone();
        change(planet, leaf.id, &mut vertices);
        let prefix = &vertices[..level.vertices as usize];
        let awake = select(&view.gpu, prefix, u32::from(leaf.coarser_sides));
        let triangles = emit(&view.gpu, prefix, patch.triangles(level), &resolve(prefix, &awake));
        patches.push((*leaf, vertices, awake, triangles));
    }
    let drawn = |(leaf, vertices, awake, triangles)| Drawn { leaf, vertices, awake, triangles };
    let drawn: Vec<Drawn> =
        patches.iter().map(|(leaf, v, a, t)| drawn((*leaf, v.as_slice(), a.as_slice(), t.as_slice()))).collect();
    let meshes: HashMap<PatchId, PatchMesh> = planet.patches.iter().map(|(id, (patch, _))| (*id, patch.mesh.clone())).collect();
    let grids = GridCache::new(&planet.tree, Box::new(move |id| Ok(meshes[&id].clone())));
    let finest = FinestSurface::new(&planet.tree, resident, &grids);
    measure(view, &planet.tree, &drawn, &finest, EFFORT).unwrap()
}

fn natural(planet: &Planet, view: &View) -> ScreenError {
    error_of(planet, view, &cut(&planet.tree, view, &|_| true), &|_| true, &|_, _, _| ())
}

/// Largest share of its tolerance that any certified view shows, and what was measured.
fn worst_share(errors: impl Iterator<Item = (View, ScreenError)>) -> f64 {
    let (mut worst, mut count, mut missed) = (0.0f64, 0, 0);
    for (view, error) in errors.filter(|(view, _)| view.scale >= 1.0) {
        let share = error.readings.max() / view.tolerance;
        if std::env::var("SHOW").is_ok() {
            println!(
                "{} px, s {:.2}: {share:.3} of {}, rim {:.3}, {:.3?}, {:?}",
                view.tolerance,
                view.scale,
                error.readings.count(),
                error.at_data_rim.max() / view.tolerance,
                [Probe::Pixel, Probe::Sleeper, Probe::FinerSample].map(|p| error.readings.max_of(p) / view.tolerance),
                error.readings.worst()
            );
        }
        missed += error.missed;
        worst = worst.max(share);
        count += error.readings.count();
    }
    assert_eq!(missed, 0);
    assert!(count > 10_000, "{count} readings prove little");
    worst
}

#[test]
fn what_is_drawn_stays_within_the_tolerance() {
    for (ridged, roughness, seed) in [(true, 0.05, 5), (false, 0.01, 6)] {
        let field = TestField { radius: 30_000.0, roughness, ridged, seed };
        let planet = planet(&field, 16);
        let share = worst_share(views(&planet, &field, 32).into_iter().map(|view| (view, natural(&planet, &view))));
        println!("{share:.3} of the tolerance");
        assert!((0.3..=1.0).contains(&share), "{share} of the tolerance with seed {seed}");
    }
}

/// A number that differs from patch to patch and from view to view.
fn dice(id: PatchId, k: usize) -> u64 {
    u64::from(id.x) * 31 + u64::from(id.y) * 17 + u64::from(id.level) * 7 + k as u64
}

#[test]
fn cuts_that_split_more_than_they_must_stay_within_the_tolerance() {
    let planet = planet(&FIELD, 16);
    let measured = views(&planet, &FIELD, 24).into_iter().enumerate().map(|(k, view)| {
        let eager =
            |id: PatchId, node: &_| urgency(&planet.tree, &view, id.level, node) * if dice(id, k) % 3 == 0 { 0.2 } else { 1.0 };
        let cut = cut_by(&planet.tree, &eager, &|_| true);
        (view, error_of(&planet, &view, &cut, &|_| true, &|_, _, _| ()))
    });
    let share = worst_share(measured);
    assert!(share <= 1.0, "{share} of the tolerance");
}

#[test]
fn where_patches_are_missing_what_is_there_stays_within_the_tolerance() {
    let planet = planet(&FIELD, 16);
    let measured = views(&planet, &FIELD, 24).into_iter().enumerate().map(|(k, view)| {
        let resident = |id: PatchId| id.level == 0 || dice(id, k) % 5 != 0;
        let cut = cut(&planet.tree, &view, &resident);
        (view, error_of(&planet, &view, &cut, &resident, &|_, _, _| ()))
    });
    let share = worst_share(measured);
    assert!(share <= 1.0, "{share} of the tolerance");
}

#[test]
fn wakes_that_are_half_as_long_are_noticed() {
    let planet = planet(&FIELD, 16);
    let halved = |_: &Planet, _: PatchId, vertices: &mut Vec<PatchVertex>| {
        for vertex in vertices {
            // A code's exponent stands above its ten bits of mantissa.
            let half = |word: u32| if word >> 16 == 0xffff { word } else { word.saturating_sub(1 << 26).max(word & 0xffff) };
            vertex.grid_own = half(vertex.grid_own);
            vertex.parent_coarser = half(vertex.parent_coarser);
        }
    };
    let changed = |view: View| (view, error_of(&planet, &view, &cut(&planet.tree, &view, &|_| true), &|_| true, &halved));
    let share = worst_share(views(&planet, &FIELD, 12).into_iter().map(changed));
    assert!(share > 1.0, "{share} of the tolerance");
}

#[test]
fn a_vertex_out_of_place_is_as_many_pixels_off() {
    let planet = planet(&FIELD, 16);
    let view = views(&planet, &FIELD, 12).into_iter().find(|view| view.scale >= 1.0).unwrap();
    let lifted_by = |pixels: f64| {
        let lift = |planet: &Planet, _: PatchId, vertices: &mut Vec<PatchVertex>| {
            for vertex in vertices {
                let place = glam::IVec3::from_array(vertex.position).as_dvec3();
                let height = pixels * view.camera.pixel_angle() * place.distance(view.eye);
                vertex.position = (place + place.normalize() * height).round().as_ivec3().to_array();
                let _ = planet;
            }
        };
        error_of(&planet, &view, &cut(&planet.tree, &view, &|_| true), &|_| true, &lift).readings
    };
    let middle = lifted_by(20.0).percentile(0.5);
    assert!((19.0..21.0).contains(&middle), "lifted by 20 pixels, measured {middle}");
}
