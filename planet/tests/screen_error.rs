//! The certificate, measured with rays: what is drawn stays within the tolerance of the finest resident surface.

use crate::common::TestField;
use crate::whole_planet::{planet, views, Planet};
use std::collections::HashMap;
use terrane_planet::draw::cut::{cut, cut_by, urgency, Cut};
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::verify::{measure, Drawn, Effort, FinestSurface, GridCache, Probe, ScreenError};

const EFFORT: Effort = Effort { pixels: 1024, finer_samples: 4096, seed: 11 };

pub(crate) const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };

pub(crate) type Change<'a> = &'a dyn Fn(&Planet, PatchId, &mut Vec<PatchVertex>);

/// Measures a cut whose vertices were changed first.
pub(crate) fn error_of(
    planet: &Planet,
    view: &View,
    cut: &Cut,
    resident: &dyn Fn(PatchId) -> bool,
    change: Change,
) -> ScreenError {
    let mut patches = Vec::new();
    for leaf in &cut.leaves {
        let (patch, _) = &planet.patches[&leaf.id];
        let work = patch.reach.work(view);
        let mut vertices = patch.vertices.clone();
        change(planet, leaf.id, &mut vertices);
        let prefix = &vertices[..work.vertices as usize];
        let Selected { awake, drawn_positions } = select(&view.gpu, prefix, u32::from(leaf.coarser_sides));
        let triangles = emit(&view.gpu, &patch.triangles(&work), &resolve(prefix, &awake), &drawn_positions);
        patches.push((*leaf, vertices, drawn_positions, triangles));
    }
    let drawn: Vec<Drawn> = patches
        .iter()
        .map(|(leaf, vertices, drawn_positions, triangles)| Drawn { leaf: *leaf, vertices, drawn_positions, triangles })
        .collect();
    let meshes: HashMap<PatchId, PatchMesh> = planet.patches.iter().map(|(id, (patch, _))| (*id, patch.mesh.clone())).collect();
    let grids = GridCache::new(&planet.tree, Box::new(move |id| Ok(meshes[&id].clone())));
    let finest = FinestSurface::new(&planet.tree, resident, &grids);
    measure(view, &planet.tree, &drawn, &finest, &|id| finest.ends_at(id), EFFORT).expect("patches in memory can be read")
}

fn natural(planet: &Planet, view: &View) -> ScreenError {
    error_of(planet, view, &cut(&planet.tree, view, &|_| true), &|_| true, &|_, _, _| ())
}

/// The kinds of probes at which the builder's bound holds by construction.
pub(crate) const AT_SAMPLES: [Probe; 2] = [Probe::Sleeper, Probe::FinerSample];

/// Largest share of its tolerance that any view shows at the points of some kinds.
pub(crate) fn worst_share(errors: impl Iterator<Item = (View, ScreenError)>, probes: &[Probe]) -> f64 {
    let (mut worst, mut count) = (0.0f64, 0);
    for (view, error) in errors {
        assert_eq!(error.missed, 0, "{:?}", view.camera);
        let pixels = probes.iter().map(|&probe| error.readings.max_of(probe)).fold(0.0, f64::max);
        worst = worst.max(pixels / view.tolerance);
        count += error.readings.count();
    }
    assert!(count > 10_000, "{count} readings prove little");
    worst
}

/// [`worst_share`] for the renderer's own cuts of a rough and of a smooth planet.
fn natural_share(probes: &[Probe]) -> f64 {
    let share = |(ridged, roughness, seed)| {
        let field = TestField { radius: 30_000.0, roughness, ridged, seed };
        let planet = planet(&field, 16);
        worst_share(views(&planet, &field, 32).into_iter().map(|view| (view, natural(&planet, &view))), probes)
    };
    [(true, 0.05, 5), (false, 0.01, 6)].into_iter().map(share).fold(0.0, f64::max)
}

#[test]
fn samples_stay_within_the_tolerance() {
    let share = natural_share(&AT_SAMPLES);
    assert!((0.3..=1.0).contains(&share), "{share} of the tolerance");
}

#[test]
fn what_lies_between_samples_stays_within_the_tolerance() {
    let share = natural_share(&[Probe::Pixel]);
    assert!((0.3..=1.0).contains(&share), "{share} of the tolerance");
}

/// A number that differs from patch to patch and from view to view.
pub(crate) fn dice(id: PatchId, k: usize) -> u64 {
    u64::from(id.x) * 31 + u64::from(id.y) * 17 + u64::from(id.level) * 7 + k as u64
}

#[test]
fn cuts_that_split_more_than_they_must_stay_within_the_tolerance() {
    let planet = planet(&FIELD, 16);
    let measured = views(&planet, &FIELD, 24).into_iter().enumerate().map(|(k, view)| {
        let eager = |id: PatchId, node: &_| {
            urgency(&planet.tree, &view, id.level, node) * if dice(id, k).is_multiple_of(3) { 0.2 } else { 1.0 }
        };
        let cut = cut_by(&planet.tree, &eager, &|_| true);
        (view, error_of(&planet, &view, &cut, &|_| true, &|_, _, _| ()))
    });
    let share = worst_share(measured, &AT_SAMPLES);
    assert!(share <= 1.0, "{share} of the tolerance");
}

#[test]
fn where_patches_are_missing_what_is_there_stays_within_the_tolerance() {
    let planet = planet(&FIELD, 16);
    let measured = views(&planet, &FIELD, 24).into_iter().enumerate().map(|(k, view)| {
        let resident = |id: PatchId| id.level == 0 || !dice(id, k).is_multiple_of(5);
        let cut = cut(&planet.tree, &view, &resident);
        (view, error_of(&planet, &view, &cut, &resident, &|_, _, _| ()))
    });
    let share = worst_share(measured, &AT_SAMPLES);
    assert!(share <= 1.0, "{share} of the tolerance");
}

#[test]
fn wakes_that_are_half_as_long_are_noticed() {
    let planet = planet(&FIELD, 16);
    let halved = |_: &Planet, _: PatchId, vertices: &mut Vec<PatchVertex>| {
        for vertex in vertices {
            // A code holds its exponent above ten bits of mantissa: the exponent less one is half the distance.
            let half = |word: u32| if word >> 16 == 0xffff { word } else { word.saturating_sub(1 << 26).max(word & 0xffff) };
            vertex.grid_wake = half(vertex.grid_wake);
            vertex.parent_coarser_wake = half(vertex.parent_coarser_wake);
        }
    };
    let changed = |view: View| (view, error_of(&planet, &view, &cut(&planet.tree, &view, &|_| true), &|_| true, &halved));
    let share = worst_share(views(&planet, &FIELD, 12).into_iter().map(changed), &AT_SAMPLES);
    assert!(share > 1.0, "{share} of the tolerance");
}

#[test]
fn a_surface_out_of_place_is_as_many_pixels_off() {
    let planet = planet(&FIELD, 16);
    let far = |a: &View, b: &View| a.eye.length().total_cmp(&b.eye.length());
    let view = views(&planet, &FIELD, 24).into_iter().max_by(far).unwrap();
    let (radius, eye) = (planet.tree.lattice.radius, view.eye.length());
    let (nearest, horizon) = (eye - 1.1 * radius, (eye * eye - 0.8 * radius * radius).sqrt());
    let lifted = 20.0 * view.camera.pixel_angle() * nearest;
    let lift = |_: &Planet, _: PatchId, vertices: &mut Vec<PatchVertex>| {
        for vertex in vertices {
            let position = glam::IVec3::from_array(vertex.position).as_dvec3();
            vertex.position = (position + position.normalize() * lifted).round().as_ivec3().to_array();
        }
    };
    let found = error_of(&planet, &view, &cut(&planet.tree, &view, &|_| true), &|_| true, &lift).readings;
    let (low, high) = (20.0 * nearest / horizon - view.tolerance, 20.0 * nearest / (nearest - lifted) + view.tolerance);
    // The probes at asleep vertices do not measure the lift: those vertices were lifted too.
    let pixels = found.max_of(Probe::Pixel);
    assert!(low > 8.0 && (low..high).contains(&pixels), "{pixels} px, expected {low} to {high}");
}
