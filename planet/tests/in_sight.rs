//! Cuts of what is in sight: nothing else need be there, and nothing that is seen tells.

use crate::common::TestField;
use crate::screen_error::{dice, error_of, worst_share, AT_SAMPLES, FIELD};
use crate::whole_planet::{planet, surface, views, Planet};
use glam::DVec3;
use std::collections::HashSet;
use terrane_planet::draw::cut::{cut, cut_in_sight, is_in_sight, Cut};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::texture::SHORE_RANGE;
use terrane_planet::verify::SurfaceReport;

/// What a view draws when nothing is missing.
fn complete(planet: &Planet, view: &View) -> Cut {
    cut_in_sight(&planet.tree, view, false, 1.0, &|_| true)
}

/// The whole faces, and four of five other patches, never mind their ancestors.
fn some(k: usize) -> impl Fn(PatchId) -> bool {
    move |id| id.level == 0 || !dice(id, k).is_multiple_of(5)
}

fn seen_report(planet: &Planet, view: &View, cut: &Cut, forget_sides: bool) -> (SurfaceReport, usize) {
    let (check, violations) = surface(planet, view, cut, forget_sides);
    (check.finish_in_sight(view, planet.tree.hidden_radius), violations)
}

#[test]
fn no_crack_can_be_seen() {
    for (seed, ridged, roughness) in [(5, true, 0.05), (6, false, 0.01)] {
        let field = TestField { radius: 30_000.0, roughness, ridged, seed };
        let planet = planet(&field, 16);
        let (mut mixed, mut fewer, mut open) = (0, 0, 0);
        for (k, view) in views(&planet, &field, 60).iter().enumerate() {
            let whole = cut(&planet.tree, view, &|_| true);
            let seen = complete(&planet, view);
            let (report, violations) = seen_report(&planet, view, &seen, false);
            let clean = SurfaceReport { triangles: report.triangles, ..Default::default() };
            assert_eq!((report, violations), (clean, 0), "view {k} of seed {seed}: {:?}", view.camera);
            mixed += usize::from(seen.leaves.iter().any(|leaf| leaf.coarser_sides != 0));
            fewer += usize::from(seen.leaves.len() < whole.leaves.len());
            open += usize::from(surface(&planet, view, &seen, false).0.finish().cracks > 0);
        }
        assert!(
            mixed > 10 && fewer > 30 && open > 30,
            "{mixed} views mix levels, {fewer} draw fewer patches, {open} have an outline"
        );
    }
}

#[test]
fn a_missing_patch_or_side_can_be_seen() {
    let planet = planet(&FIELD, 16);
    let (mut holes, mut cracked) = (0, 0);
    for view in views(&planet, &FIELD, 40) {
        let mut cut = complete(&planet, &view);
        cracked += usize::from(seen_report(&planet, &view, &cut, true).0.cracks > 0);
        cut.leaves.remove(cut.leaves.len() / 2);
        holes += usize::from(seen_report(&planet, &view, &cut, false).0.cracks > 0);
    }
    assert!(cracked > 5 && holes > 10, "{cracked} views with cracks and {holes} with holes: the check cannot fail");
}

#[test]
fn where_patches_are_missing_no_crack_can_be_seen_either() {
    let planet = planet(&FIELD, 16);
    let mut coarser = 0;
    for (k, view) in views(&planet, &FIELD, 40).iter().enumerate() {
        let resident = some(k);
        let cut = cut_in_sight(&planet.tree, view, false, 1.0, &resident);
        assert!(cut.leaves.iter().all(|leaf| resident(leaf.id)), "view {k} draws what is not there");
        let (report, _) = seen_report(&planet, view, &cut, false);
        assert_eq!((report.cracks, report.flipped), (0, 0), "view {k}: {:?}", view.camera);
        coarser += usize::from(!cut.wanted.is_empty());
    }
    assert!(coarser > 10, "only {coarser} views lack a patch");
}

#[test]
fn a_picture_needs_only_the_patches_that_it_draws() {
    let planet = planet(&FIELD, 16);
    let mut without_ancestors = 0;
    for view in views(&planet, &FIELD, 40) {
        let whole = complete(&planet, &view);
        let drawn: HashSet<PatchId> = whole.leaves.iter().map(|leaf| leaf.id).collect();
        let cut = cut_in_sight(&planet.tree, &view, false, 1.0, &|id| drawn.contains(&id));
        assert!(cut.leaves == whole.leaves && cut.wanted.is_empty());
        without_ancestors += usize::from(drawn.iter().any(|id| id.level > 1));
    }
    assert!(without_ancestors > 10);
}

#[test]
fn finer_patches_stand_in_for_a_missing_one() {
    let planet = planet(&FIELD, 16);
    let mut stood_in = 0;
    for view in views(&planet, &FIELD, 40) {
        let whole = complete(&planet, &view);
        let Some(gone) = whole.leaves.iter().map(|leaf| leaf.id).find(|&id| id.level > 0 && planet.tree.can_split(id)) else {
            continue;
        };
        let cut = cut_in_sight(&planet.tree, &view, false, 1.0, &|id| id != gone);
        assert!(cut.leaves.iter().all(|leaf| leaf.id != gone) && cut.wanted.iter().any(|(id, _)| *id == gone));
        let (report, _) = seen_report(&planet, &view, &cut, false);
        assert_eq!((report.cracks, report.flipped), (0, 0), "{:?}", view.camera);
        stood_in += usize::from(cut.leaves.iter().any(|leaf| leaf.id.parent() == Some(gone)));
    }
    assert!(stood_in > 0, "finer patches stood in {stood_in} times");
}

#[test]
fn what_is_in_sight_stays_within_the_tolerance() {
    let planet = planet(&FIELD, 16);
    let measured = views(&planet, &FIELD, 24).into_iter().enumerate().map(|(k, view)| {
        // The judge's own surface covers the whole planet.
        let partly = |id| some(k)(id) || !is_in_sight(&planet.tree, &view, id);
        let resident: &dyn Fn(PatchId) -> bool = if k % 2 == 0 { &|_| true } else { &partly };
        let cut = cut_in_sight(&planet.tree, &view, false, 1.0, resident);
        (view, error_of(&planet, &view, &cut, resident, &|_, _, _| ()))
    });
    let share = worst_share(measured, &AT_SAMPLES);
    assert!(share <= 1.0, "{share} of the tolerance");
}

/// The planet of a field under a sea that reaches so many metres above the datum.
fn under_a_sea(field: &TestField, level_m: f64) -> Planet {
    let mut planet = planet(field, 16);
    let empty = planet.tree.emptied();
    let known = std::mem::replace(&mut planet.tree, empty);
    planet.tree = known.with_sea(level_m, f64::MAX);
    planet
}

#[test]
fn ground_in_the_dark_of_the_sea_splits_for_nobody_above_it() {
    let dry = planet(&FIELD, 16);
    let unit = dry.tree.lattice.unit;
    let highest = f64::from(PatchId::roots().map(|root| dry.patches[&root].0.mesh.facts.heights[1]).max().unwrap()) * unit;
    // Slopes a little above the deepest ground, and all of it, are in the dark.
    let (mut fewer, mut dark) = (0, 0);
    for (k, share) in [0.2, 1.5, 4.0].into_iter().cycle().take(12).enumerate() {
        let wet = under_a_sea(&FIELD, share * highest + SHORE_RANGE);
        let sea = wet.tree.sea.unwrap();
        let site = DVec3::new((k as f64).sin(), (1.7 * k as f64).cos(), (0.9 * k as f64).sin()).normalize();
        let above = |metres: f64| {
            let camera = Camera::looking(site * (sea.surface * unit + metres), 40.0 * k as f64, -25.0, 1.0, [1280, 720]);
            View::new(camera, &wet.tree.lattice, wet.tree.cells, 1.0).without_culling()
        };
        let [shown, hidden] = [&dry, &wet].map(|planet| complete(planet, &above(1500.0)).leaves);
        fewer += usize::from(hidden.len() < shown.len());
        let [shown, hidden] = [&dry, &wet].map(|planet| complete(planet, &above(-10.0)).leaves);
        assert_eq!(shown, hidden, "the sea hides nothing from below");
        let view = above(1500.0);
        let cut = complete(&wet, &view);
        let (report, _) = seen_report(&wet, &view, &cut, false);
        assert_eq!((report.cracks, report.flipped), (0, 0), "{:?}", view.camera);
        let error = error_of(&wet, &view, &cut, &|_| true, &|_, _, _| ());
        let worst = AT_SAMPLES.iter().map(|&probe| error.readings.max_of(probe)).fold(0.0, f64::max);
        assert!(worst <= view.tolerance, "{worst} px");
        dark += error.in_the_dark;
    }
    assert!(fewer > 0 && dark > 1000, "{fewer} views draw fewer patches, {dark} points in the dark");
}
