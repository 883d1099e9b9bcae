//! Heights of the known ground and hits of rays with it: they lie on the triangles of the finest patches that are known there.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use crate::common::TestField;
use glam::DVec3;
use std::path::Path;
use std::sync::{Arc, RwLock};
use std::time::Duration;
use terrane_heightfield::decimate::mesh::grid_triangles;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::random::Random;
use terrane_planet::globe::sphere::{direction, direction_at};
use terrane_planet::ground::HeightGrid;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::Planet;
use terrane_planet::query::{KnownGround, PatchGrid, Refiner};
use terrane_planet::recipe::Recipe;

const CELLS: u32 = 16;
const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };
/// By how much rounded corners of the lattice may move the ground on the border of a patch, in lattice units.
const BORDER: f64 = 8.0;

/// The leaves of the known ground: all of level 1, one quarter of each to level 3, and one corner to level 8, beside far coarser ones.
fn leaves() -> Vec<PatchId> {
    let mut leaves = Vec::new();
    let mut open: Vec<PatchId> = PatchId::roots().collect();
    while let Some(id) = open.pop() {
        let steep = id.face.index() == 3 && id.x == 0 && id.y == 0 && id.level < 8;
        if id.level == 0 || (id.level < 3 && id.x.is_multiple_of(2) && id.y.is_multiple_of(2)) || steep {
            open.extend(id.children().unwrap());
        } else {
            leaves.push(id);
        }
    }
    leaves
}

fn known(field: &TestField, leaves: &[PatchId]) -> KnownGround {
    let ground = field.ground(CELLS);
    let mut known = KnownGround::new(ground.lattice, CELLS);
    for &leaf in leaves {
        let mut at = Some(leaf);
        while let Some(id) = at.filter(|&id| !known.contains(id)) {
            assert!(known.insert(PatchGrid::sample(&ground, id)));
            at = id.parent();
        }
    }
    known
}

/// A point on a random triangle of a patch's grid, in lattice units, and whether the triangle is at the border of the patch.
fn random_point(random: &mut Random, field: &TestField, id: PatchId) -> (DVec3, bool) {
    let ground = field.ground(CELLS);
    let triangles = grid_triangles(CELLS);
    let corners = triangles[random.bits() as usize % triangles.len()];
    let n = CELLS + 1;
    let border = corners.iter().any(|v| (v % n).is_multiple_of(CELLS) || (v / n).is_multiple_of(CELLS));
    let points = corners.map(|v| id.point((v % n) as i32, (v / n) as i32, CELLS));
    let [a, b, c] = points.map(|p| ground.points(&[p])[0].position);
    let (mut s, mut t) = (random.unit(), random.unit());
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    (a + (b - a) * s + (c - a) * t, border)
}

/// Largest distance in lattice units of queried heights from triangles of the leaves: inside of leaves, and at their borders.
fn worst(known: &KnownGround, leaves: &[PatchId]) -> [f64; 2] {
    let mut random = Random::new(3);
    let mut worst = [0.0f64; 2];
    for &id in leaves {
        for _ in 0..60 {
            let (point, border) = random_point(&mut random, &FIELD, id);
            let found = known.height_at(point * 17.0).unwrap();
            // Beside a patch of another level, rounded corners may put the point into that patch.
            if border && found.level != id.level {
                continue;
            }
            let wanted = (point.length() - known.lattice.radius) * known.lattice.unit;
            worst[usize::from(border)] = worst[usize::from(border)].max((found.height - wanted).abs() / known.lattice.unit);
        }
    }
    worst
}

#[test]
fn heights_lie_on_the_triangles_of_the_finest_patches() {
    let leaves = leaves();
    let [inside, border] = worst(&known(&FIELD, &leaves), &leaves);
    assert!(inside < 1e-3 && border < BORDER, "{inside} units inside, {border} at borders");
}

#[test]
fn heights_of_coarser_patches_are_noticed() {
    let leaves = leaves();
    let mut known = known(&FIELD, &leaves);
    // Without one of four siblings, the parent gives the heights of all four; all others stay the same.
    let lost = *leaves.iter().find(|id| id.level == 3).unwrap();
    known.remove(lost);
    let (gone, kept): (Vec<PatchId>, Vec<PatchId>) = leaves.iter().partition(|id| id.parent() == lost.parent());
    assert!(gone.len() == 4 && worst(&known, &gone)[0] > 1000.0);
    assert!(worst(&known, &kept)[0] < 1e-3);
    let direction = lost.centre();
    assert_eq!(known.height_at(direction).unwrap().level, 2);
    assert!(known.insert(PatchGrid::sample(&FIELD.ground(CELLS), lost)));
    let found = known.height_at(direction).unwrap();
    assert_eq!((found.level, found.spacing), (3, known.spacing(3)));
    // Forgotten together, they give way to their parent as well, and nothing else does.
    let count = known.len();
    known.forget(|id| id.parent() == lost.parent());
    assert_eq!((known.len(), known.height_at(direction).unwrap().level), (count - 4, 2));
    assert!(worst(&known, &kept)[0] < 1e-3);
    gone.iter().for_each(|&id| assert!(known.insert(PatchGrid::sample(&FIELD.ground(CELLS), id))));
    assert_eq!(known.height_at(direction).unwrap(), found);
    assert!((found.spacing * 8.0 * f64::from(CELLS) / FIELD.radius - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
}

#[test]
fn sampled_grids_are_those_of_built_patches() {
    let ground = FIELD.ground(CELLS);
    let mut random = Random::new(9);
    for id in leaves().into_iter().step_by(17) {
        let (mesh, _) = PatchMesh::build(&ground, &HeightGrid::sample(&ground, id));
        let built = PatchGrid::of_mesh(&mesh, &ground.lattice);
        let surveyed = PatchGrid::of_survey(&HeightGrid::sample(&ground, id), CELLS, &ground.lattice);
        for sampled in [PatchGrid::sample(&ground, id), surveyed] {
            assert_eq!(sampled.highest, built.highest, "{id}");
            for _ in 0..50 {
                let direction = random_point(&mut random, &FIELD, id).0.normalize();
                assert!(built.radius(direction).is_some() && built.radius(direction) == sampled.radius(direction), "{id}");
            }
        }
    }
}

/// How far below the ground a point is, in metres.
fn depth(known: &KnownGround, point: DVec3) -> f64 {
    known.height_at(point).unwrap().height - (point.length() - FIELD.radius)
}

/// The point's direction and directions on all sides of it.
fn around(point: DVec3) -> impl Iterator<Item = DVec3> {
    let offset = |k: usize| DVec3::new([-1e-7, 1e-7][k % 2], [-1e-7, 1e-7][k / 2 % 2], [-1e-7, 1e-7][k / 4]);
    (0..8).map(move |k| point.normalize() + offset(k))
}

/// Whether a point is below the ground of all patches around it.
fn is_inside(known: &KnownGround, point: DVec3) -> bool {
    let below =
        |direction| known.height_at(direction).unwrap().height + FIELD.radius - point.length() > BORDER * known.lattice.unit;
    below(point) && around(point).all(below)
}

/// Rays from above the ground towards points on it or a little below, many of them grazing.
fn rays(known: &KnownGround, leaves: &[PatchId], count: usize) -> Vec<(DVec3, DVec3)> {
    let mut random = Random::new(21);
    let mut ray = || {
        let leaf = leaves[random.bits() as usize % leaves.len()];
        let target = random_point(&mut random, &FIELD, leaf).0 * known.lattice.unit;
        let aside = target.normalize().any_orthonormal_vector() * random.range(-1.0, 1.0)
            + target.normalize().cross(target.normalize().any_orthonormal_vector()) * random.range(-1.0, 1.0);
        let from = (target.normalize() + aside * 2.0f64.powf(-8.0 * random.unit())).normalize();
        let ground = known.height_at(from).unwrap().height;
        let origin = from * (FIELD.radius + ground + 2.0f64.powf(random.range(0.0, 15.0)));
        (origin, target - origin)
    };
    let mut rays: Vec<_> = (0..count).map(|_| ray()).collect();
    // Rays that begin exactly above sides and corners of patches, and rays along sides.
    for &leaf in leaves {
        let points = [(0, 0), (0, 1), (2, 0), (2, 2), (1, 2), (1, 1)].map(|(a, b)| direction(leaf.point(a, b, 2)));
        // Where levels differ, they begin above the higher ground and end below the lower.
        let heights = |direction| around(direction).map(|direction| FIELD.radius + known.height_at(direction).unwrap().height);
        let above = points.map(|direction| direction * (heights(direction).fold(0.0, f64::max) + 40.0));
        let below = points.map(|direction| direction * (heights(direction).fold(f64::MAX, f64::min) - 10.0));
        rays.extend(below.into_iter().flat_map(|target| above.map(|origin| (origin, target - origin))));
    }
    rays
}

#[test]
fn rays_end_where_they_first_come_below_the_ground() {
    let leaves = leaves();
    let known = known(&FIELD, &leaves);
    let rounding = BORDER * known.lattice.unit;
    let (mut steps, mut rays_met) = (0, 0);
    for (origin, line) in rays(&known, &leaves, 3000) {
        let hit = known.raycast(origin, line).unwrap_or_else(|| panic!("{origin} {line}"));
        let ray = line.normalize();
        assert!(hit.distance <= line.length() + 100.0 * rounding, "beyond its target by {}", hit.distance - line.length());
        assert!((origin + ray * hit.distance).distance(hit.position) < 1e-6);
        assert!((hit.position.length() - FIELD.radius - hit.height).abs() < 1e-6);
        // On the surface, or in a step between patches of different levels.
        let above = depth(&known, hit.position + hit.position * 1e-9).abs();
        steps += usize::from(above > rounding);
        rays_met += 1;
        for k in 0..200 {
            let point = origin + ray * (hit.distance * f64::from(k) / 200.0);
            assert!(!is_inside(&known, point), "below the ground at {point}, before {hit:?} from {origin}");
        }
    }
    assert!(steps < rays_met / 20, "{steps} of {rays_met} rays ended elsewhere than on the surface");
}

#[test]
fn steps_between_levels_stop_rays() {
    // Fine patches lie beside far coarser ones: rays along the fine ground meet the steps at its border.
    let leaves = leaves();
    let known = known(&FIELD, &leaves);
    let fine: Vec<PatchId> = leaves.iter().copied().filter(|id| id.level == 8).collect();
    let mut random = Random::new(2);
    let mut stopped = 0;
    for _ in 0..2000 {
        let leaf = fine[random.bits() as usize % fine.len()];
        let point = random_point(&mut random, &FIELD, leaf).0 * known.lattice.unit;
        let up = point.normalize();
        let along = (up.any_orthonormal_vector() * random.range(-1.0, 1.0)
            + up.cross(up.any_orthonormal_vector()) * random.range(-1.0, 1.0))
        .normalize();
        let origin = point + up * 0.5;
        let Some(hit) = known.raycast(origin, along) else { continue };
        let depth = depth(&known, hit.position + along * 1e-3);
        stopped += usize::from(depth > 1.0);
        let before = origin + along * (hit.distance - 1e-2).max(0.0);
        assert!(self::depth(&known, before) < BORDER * known.lattice.unit);
    }
    assert!(stopped > 5, "{stopped} rays met a step: the test proves little");
}

#[test]
fn rays_that_begin_in_the_ground_end_there() {
    let known = known(&FIELD, &PatchId::roots().collect::<Vec<_>>());
    for origin in [DVec3::ZERO, DVec3::new(1e-9, 0.0, 0.0), DVec3::new(0.0, -2e4, 300.0), direction_at(90.0, 0.0) * 26e3] {
        for direction in DVec3::AXES {
            let hit = known.raycast(origin, direction).unwrap();
            assert_eq!((hit.distance, hit.position), (0.0, origin));
        }
    }
}

#[test]
fn rays_from_afar_are_as_exact_as_those_from_nearby() {
    let known = known(&FIELD, &leaves());
    let mut random = Random::new(4);
    for &id in &leaves() {
        let site = random_point(&mut random, &FIELD, id).0.normalize();
        let ground = known.height_at(site).unwrap().height;
        for distance in [10.0, 1e5, 1e9] {
            let hit = known.raycast(site * (FIELD.radius + ground + distance), -site).unwrap();
            assert!((hit.distance - distance).abs() < 1e-3 + distance * 1e-9 && (hit.height - ground).abs() < 1e-3, "{hit:?}");
        }
        let away = known.raycast(site * (FIELD.radius + ground + 1.0), site);
        assert_eq!(away, None);
    }
    assert_eq!(known.raycast(DVec3::new(1e9, 0.0, 1e5), -DVec3::X), None);
}

#[test]
fn what_is_no_ray_meets_nothing() {
    let empty = KnownGround::new(Lattice::new(FIELD.radius, 100.0), CELLS);
    assert_eq!((empty.height_at(DVec3::X), empty.raycast(DVec3::X * 1e6, -DVec3::X)), (None, None));
    let known = known(&FIELD, &[PatchId::roots().next().unwrap()]);
    assert_eq!(known.height_at(DVec3::ZERO), None);
    assert!(known.height_at(DVec3::X).is_some() && known.height_at(-DVec3::X).is_none());
    for bad in [DVec3::NAN, DVec3::INFINITY, DVec3::ZERO] {
        assert_eq!(known.height_at(bad), None);
        assert_eq!(known.raycast(DVec3::X * 1e6, bad), None);
    }
    assert_eq!(known.raycast(DVec3::NAN, -DVec3::X), None);
    assert_eq!(known.raycast(DVec3::INFINITY, -DVec3::X), None);
    // A ray through the unknown far side ends where it comes below the known near side.
    let through = known.raycast(DVec3::X * -1e6, DVec3::X).unwrap();
    assert!(through.patch == PatchId::roots().next().unwrap() && through.position.length() < FIELD.radius * 1.1, "{through:?}");
}

#[test]
fn grids_of_another_planet_are_not_taken() {
    let mut known = known(&FIELD, &[]);
    let root = PatchId::roots().next().unwrap();
    assert!(!known.insert(PatchGrid::sample(&FIELD.ground(2 * CELLS), root)));
    let other = TestField { radius: 60_000.0, ..FIELD };
    assert!(!known.insert(PatchGrid::sample(&other.ground(CELLS), root)) && known.is_empty());
}

fn tiny() -> Arc<Planet> {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    Arc::new(Planet::from_recipe(Recipe::load(&recipe).unwrap(), 32).unwrap())
}

const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn refined_ground_comes_as_near_to_the_terrain_as_was_asked() {
    let planet = tiny();
    let known = Arc::new(RwLock::new(KnownGround::new(planet.lattice, planet.cells)));
    let refiner = Refiner::new(planet.clone(), known.clone());
    let site = direction_at(47.0, 11.0);
    let error = || (known.read().unwrap().height_at(site).unwrap().height - planet.terrain.height(site)).abs();
    let mut errors = Vec::new();
    for spacing in [2000.0, 50.0, 0.5] {
        let refinement = refiner.refine(site, spacing);
        assert!(refinement.wait(PATIENCE) && refinement.is_done());
        let found = known.read().unwrap().height_at(site).unwrap();
        assert!(found.spacing <= spacing && found.spacing > spacing / 2.0, "{found:?}");
        errors.push(error());
    }
    assert!(errors[2] < 0.05 && errors[0] > 20.0 * errors[2], "{errors:?}");
    let built = known.read().unwrap().len();
    assert!(refiner.refine(site, 0.5).is_done() && known.read().unwrap().len() == built, "it was refined twice");
}

#[test]
fn requests_that_nobody_waits_for_are_dropped() {
    let planet = tiny();
    let known = Arc::new(RwLock::new(KnownGround::new(planet.lattice, planet.cells)));
    let refiner = Refiner::new(planet, known.clone());
    let (here, there) = (direction_at(10.0, 10.0), direction_at(-10.0, -170.0));
    let first = refiner.refine(here, 0.5);
    drop(refiner.refine(there, 0.5));
    assert!(!first.wait(Duration::ZERO));
    assert!(first.wait(PATIENCE));
    let last = refiner.refine(here, 0.2);
    assert!(last.wait(PATIENCE));
    let known = known.read().unwrap();
    assert!(known.height_at(there).is_none() && known.height_at(here).unwrap().spacing <= 0.2);
    drop(refiner);
}
