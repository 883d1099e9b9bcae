//! Whole planets on the CPU, in random views with mixed levels: watertight by position bits, no flipped triangle, and no awake vertex
//! without those that it needs.

use crate::common::TestField;
use crate::whole_planet::{draw, planet, views, Planet};
use std::collections::HashMap;
use terrane_planet::draw::cut::cut;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::verify::SurfaceReport;

#[test]
fn every_view_is_watertight_unflipped_and_closed() {
    for (seed, ridged, roughness) in [(5, true, 0.05), (6, false, 0.01)] {
        let field = TestField { radius: 30_000.0, roughness, ridged, seed };
        let planet = planet(&field, 16);
        let mut levels = 0;
        for (k, view) in views(&planet, &field, 60).iter().enumerate() {
            let cut = cut(&planet.tree, view, &|_| true);
            levels = levels.max(cut.leaves.iter().filter(|l| l.coarser_sides != 0).count());
            let (report, violations) = draw(&planet, view, &cut, false);
            assert_eq!(report.cracks, 0, "view {k} of seed {seed}: {:?}", view.camera);
            let clean = SurfaceReport { triangles: report.triangles, ..Default::default() };
            assert_eq!((report, violations), (clean, 0), "view {k} of seed {seed}: {:?}", view.camera);
            assert!(report.triangles > 100);
        }
        assert!(levels > 0, "no view mixed levels: the test would prove nothing about them");
    }
}

/// Views near the ground that the orientation term changes.
fn oriented(planet: &Planet, field: &TestField) -> Vec<View> {
    let finer = views(planet, field, 80).into_iter().map(|view| {
        let finer = View::new(view.camera, &planet.tree.lattice, planet.tree.cells, 0.4 * view.tolerance);
        finer.without_culling().with_orientation(planet.tree.hidden_radius)
    });
    finer.filter(|view| view.orientation.is_some()).collect()
}

#[test]
fn the_orientation_term_keeps_the_surface_closed() {
    let field = TestField { radius: 300_000.0, roughness: 0.02, ridged: true, seed: 5 };
    let planet = planet(&field, 16);
    let views = oriented(&planet, &field);
    let (mut fewer, mut steeper_violations) = (0, 0);
    for (k, view) in views.iter().enumerate() {
        let cut = cut(&planet.tree, view, &|_| true);
        let (report, violations) = draw(&planet, view, &cut, false);
        let clean = SurfaceReport { triangles: report.triangles, ..Default::default() };
        assert_eq!((report, violations), (clean, 0), "view {k}: {:?} {:?}", view.camera, view.orientation);
        let plain = View::new(view.camera, &planet.tree.lattice, planet.tree.cells, view.tolerance).without_culling();
        fewer += usize::from(draw(&planet, &plain, &cut, false).0.triangles > report.triangles);
        let mut steeper = *view;
        steeper.gpu.height_weight *= 4.0;
        steeper_violations += draw(&planet, &steeper, &cut, false).1;
    }
    assert!(views.len() > 20 && fewer > 3, "{} views, {fewer} with fewer triangles", views.len());
    assert!(steeper_violations > 0, "the closure check cannot fail");
}

#[test]
fn forgetting_the_coarser_sides_cracks_the_surface() {
    let field = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };
    let planet = planet(&field, 16);
    let cracked =
        views(&planet, &field, 40).iter().any(|view| draw(&planet, view, &cut(&planet.tree, view, &|_| true), true).0.cracks > 0);
    assert!(cracked, "the crack test cannot fail");
}

#[test]
fn patches_that_are_not_resident_make_a_coarser_picture_without_cracks() {
    let field = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 8 };
    let planet = planet(&field, 16);
    let mut coarser = 0;
    for (k, view) in views(&planet, &field, 30).iter().enumerate() {
        let resident = |id: PatchId| id.level == 0 || !(u64::from(id.x) * 31 + u64::from(id.y) * 17 + k as u64).is_multiple_of(5);
        let (whole, cut) = (cut(&planet.tree, view, &|_| true), cut(&planet.tree, view, &resident));
        let (report, _) = draw(&planet, view, &cut, false);
        assert_eq!(report.cracks, 0, "view {k}");
        assert_eq!(report.flipped, 0, "view {k}: {report:?}");
        assert!(cut.leaves.iter().all(|leaf| resident(leaf.id)));
        coarser += usize::from(cut.leaves.len() < whole.leaves.len());
    }
    assert!(coarser > 10, "only {coarser} views lack a patch");
}

#[test]
fn neighbours_differ_by_one_level_at_most() {
    let field = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };
    let planet = planet(&field, 16);
    let mut mixed = 0;
    for view in views(&planet, &field, 30) {
        let leaves: HashMap<PatchId, ()> = cut(&planet.tree, &view, &|_| true).leaves.iter().map(|l| (l.id, ())).collect();
        for &id in leaves.keys() {
            for side in terrane_planet::globe::patch::Side::ALL {
                let mut other = Some(id.neighbour(side));
                let found = std::iter::from_fn(|| {
                    let now = other;
                    other = now.and_then(PatchId::parent);
                    now
                })
                .find(|p| leaves.contains_key(p));
                assert!(found.is_none_or(|p| id.level - p.level <= 1), "{id} next to {found:?}");
                mixed += usize::from(found.is_some_and(|p| id.level > p.level));
            }
        }
    }
    assert!(mixed > 0, "no view mixed levels: the test would prove nothing about them");
}
