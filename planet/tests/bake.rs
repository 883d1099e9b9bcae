//! Bake plans, and the bytes of a bake: the same for any number of threads and any interruption.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use glam::DVec3;
use std::collections::HashSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::bake::{bake, BakePlan, PlanError};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::PlanetFile;
use terrane_planet::store::Region;

const RADIUS: f64 = 6_371_000.0;

fn region(latitude: f64, longitude: f64, radius_m: f64, to_level: u8) -> Region {
    Region { direction: direction_at(latitude, longitude), radius_m, to_level }
}

/// The first patch whose parent, siblings or parent's neighbours are missing.
fn unbalanced(patches: &[PatchId]) -> Option<PatchId> {
    let set: HashSet<PatchId> = patches.iter().copied().collect();
    let whole = |id: PatchId| {
        set.contains(&id) && id.parent().and_then(PatchId::children).is_none_or(|s| s.iter().all(|c| set.contains(c)))
    };
    let sound = |id: &PatchId| {
        let Some(parent) = id.parent() else { return true };
        whole(*id) && whole(parent) && Side::ALL.iter().all(|&side| set.contains(&parent.neighbour(side)))
    };
    patches.iter().copied().find(|id| !sound(id))
}

fn sites() -> [(f64, f64); 6] {
    // Mid-face, a cube edge, a cube corner, both poles, and a spot beside an edge.
    [(10.0, 20.0), (0.0, 45.0), (35.264_389_7, 45.0), (90.0, 0.0), (-90.0, 0.0), (44.9, -90.3)]
}

#[test]
fn regions_are_balanced_also_over_cube_edges_and_corners() {
    for (latitude, longitude) in sites() {
        for radius in [0.0, 10e3, 2000e3] {
            let region = region(latitude, longitude, radius, 7);
            let plan = BakePlan::new(RADIUS, 2, Some(region)).unwrap();
            assert_eq!(unbalanced(&plan.patches), None, "{latitude} {longitude} {radius}");
            assert!(plan.patches.contains(&PatchId::containing(region.direction, 7)));
            assert!(plan.patches.is_sorted_by_key(|id| id.level));
            assert_eq!(plan.patches.iter().collect::<HashSet<_>>().len(), plan.patches.len());
        }
    }
}

#[test]
fn the_balance_check_sees_a_missing_patch() {
    let mut patches = BakePlan::new(RADIUS, 1, Some(region(0.0, 45.0, 0.0, 5))).unwrap().patches;
    let needed = patches.iter().rposition(|id| id.level == 4).unwrap();
    patches.remove(needed);
    assert!(unbalanced(&patches).is_some());
}

#[test]
fn a_region_reaches_as_far_as_its_radius() {
    let plan = BakePlan::new(RADIUS, 2, Some(region(10.0, 20.0, 300e3, 6))).unwrap();
    let finest: HashSet<PatchId> = plan.patches.iter().copied().filter(|id| id.level == 6).collect();
    for k in 0..64 {
        let turn = f64::from(k) * std::f64::consts::TAU / 64.0;
        let degrees = 300e3 / RADIUS * 180.0 / std::f64::consts::PI;
        let direction = direction_at(10.0 + degrees * turn.sin(), 20.0 + degrees * turn.cos());
        assert!(finest.contains(&PatchId::containing(direction, 6)), "{k}");
    }
    assert!(finest.len() < 6 << 12, "the whole planet");
}

#[test]
fn plans_without_a_region_are_whole_planets() {
    assert_eq!(BakePlan::new(RADIUS, 0, None).unwrap().patches.len(), 6);
    assert_eq!(BakePlan::new(RADIUS, 3, None).unwrap().patches.len(), 510);
}

#[test]
fn impossible_plans_are_refused() {
    assert_eq!(BakePlan::new(RADIUS, 40, None), Err(PlanError::TooDeep { found: 40 }));
    assert_eq!(BakePlan::new(RADIUS, 12, None), Err(PlanError::TooMany));
    assert_eq!(BakePlan::new(RADIUS, 1, Some(region(0.0, 0.0, 20e6, 14))), Err(PlanError::TooMany));
    assert_eq!(BakePlan::new(RADIUS, 3, Some(region(0.0, 0.0, 1.0, 3))), Err(PlanError::RegionNotFiner { found: 3, levels: 3 }));
    let nowhere = Region { direction: DVec3::ZERO, radius_m: 1.0, to_level: 9 };
    assert!(matches!(BakePlan::new(RADIUS, 3, Some(nowhere)), Err(PlanError::NoRegion { .. })));
    assert!(matches!(BakePlan::new(RADIUS, 3, Some(region(0.0, 0.0, f64::NAN, 5))), Err(PlanError::NoRegion { .. })));
}

fn tiny() -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    Planet::from_recipe(Recipe::load(&path).unwrap(), 16).unwrap()
}

fn records(path: &Path) -> Vec<(PatchId, Vec<u8>, Vec<u8>)> {
    let file = PlanetFile::open(path).unwrap();
    let record = |id| (id, file.geometry_record(id).unwrap(), file.texture_record(id).unwrap());
    file.index().unwrap().into_iter().map(|r| record(r.id)).collect()
}

#[test]
fn threads_order_and_a_stop_do_not_change_bytes() {
    let (folder, planet) = (tempfile::tempdir().unwrap(), tiny());
    let plan = BakePlan::new(planet.recipe.radius, 2, None).unwrap();
    let go = |name: &str, plan: &BakePlan, threads, stop_at: usize| {
        let path = folder.path().join(name);
        let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
        let stop = AtomicBool::new(false);
        let progress = |p: terrane_planet::planet::bake::Progress| {
            stop.fetch_or(p.built >= stop_at, Ordering::Relaxed);
        };
        let summary = bake(&mut file, &planet.terrain, &planet.terrain, plan, threads, &progress, &stop).unwrap();
        (path, summary)
    };
    let (one, summary) = go("one", &plan, 1, usize::MAX);
    assert!(!summary.interrupted && summary.built == 126);
    let expected = records(&one);
    let (two, _) = go("two", &plan, 2, usize::MAX);
    assert!(records(&two) == expected, "two threads");
    let mut backwards = plan.clone();
    backwards.patches.reverse();
    assert!(records(&go("back", &backwards, 3, usize::MAX).0) == expected, "another order");
    let (_, summary) = go("stop", &plan, 2, 40);
    assert!(summary.interrupted && (40..126).contains(&summary.built), "{summary:?}");
    let (resumed, rest) = go("stop", &plan, 2, usize::MAX);
    assert_eq!((rest.skipped, rest.built, rest.interrupted), (summary.built, 126 - summary.built, false));
    assert!(records(&resumed) == expected, "after a stop");
    // The comparison finds one changed byte.
    let mut changed = records(&two);
    changed[77].1[100] ^= 1;
    assert!(changed != expected);
}
