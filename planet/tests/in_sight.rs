//! Cuts of what is in sight: nothing else need be there, and nothing that is seen tells.

use crate::common::TestField;
use crate::screen_error::{dice, error_of, worst_share, AT_SAMPLES, FIELD};
use crate::whole_planet::{planet, surface, views, Planet};
use std::collections::HashSet;
use terrane_planet::draw::cut::{cut, cut_in_sight, is_in_sight, Cut};
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
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
