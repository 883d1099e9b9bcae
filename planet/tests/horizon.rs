//! Horizon angles and ambient occlusion of patches, against angles that brute force finds on the terrain at many more directions.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use glam::DVec3;
use std::path::Path;
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::{direction, direction_at};
use terrane_planet::ground::horizon::HorizonMap;
use terrane_planet::ground::surroundings::KnownSurroundings;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;

const CELLS: u32 = 64;

fn planet(name: &str) -> Planet {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recipes/{name}.toml"));
    Planet::from_recipe(Recipe::load(&recipe).unwrap(), CELLS).unwrap()
}

/// A sun low over a site, in the azimuth of a number.
fn low_sun(site: DVec3, azimuth: f64) -> DVec3 {
    let east = DVec3::Z.cross(site).normalize();
    let north = site.cross(east);
    (0.15 * site + east * azimuth.sin() + north * azimuth.cos()).normalize()
}

/// Sine of the horizon angle by brute force: the terrain at steps of an eighth of a cell near the site, and at longer ones farther away.
fn brute(planet: &Planet, up: DVec3, sun: DVec3, cell: f64) -> f64 {
    let towards = (sun - up * sun.dot(up)).normalize();
    let own = planet.terrain.height(up);
    let (mut angle, mut most) = (cell, f64::MIN);
    while angle < 0.1 {
        let there = up * angle.cos() + towards * angle.sin();
        let (a, b) = (planet.recipe.radius + own, planet.recipe.radius + planet.terrain.height(there));
        let rise = b * angle.cos() - a;
        most = most.max(rise / rise.hypot(b * angle.sin()));
        angle += (0.125 * cell).max(0.02 * angle);
    }
    most
}

/// A site in Luna's highlands: in a mare a sun of any azimuth sees the same horizon.
const CRATERED: [f64; 2] = [-20.0, -60.0];

/// Differences of maps from brute force over patches of a planet, sorted. The maps are made for a sun that is turned by `turn` radians.
fn differences(planet: &Planet, turn: f64) -> Vec<f64> {
    let (ground, known, mut differences) = (planet.ground(), KnownSurroundings::default(), Vec::new());
    for (k, level) in [6u8, 9, 12].into_iter().enumerate() {
        let id = PatchId::containing(direction_at(CRATERED[0], CRATERED[1]), level);
        let azimuth = 1.0 + k as f64;
        let map = HorizonMap::new(&ground, id, low_sun(id.centre(), azimuth + turn), &mut known.sampled(&ground));
        let sun = low_sun(id.centre(), azimuth);
        let cell = std::f64::consts::FRAC_PI_2 / f64::from(CELLS << level);
        for (x, y) in (0..=CELLS as i32).step_by(7).flat_map(|y| (0..=CELLS as i32).step_by(7).map(move |x| (x, y))) {
            let up = direction(id.point(x, y, CELLS));
            let found = f64::from(map.horizon[(y * (CELLS as i32 + 1) + x) as usize]);
            differences.push((found - brute(planet, up, sun, cell)).abs());
        }
    }
    differences.sort_unstable_by(f64::total_cmp);
    differences
}

#[test]
fn horizon_angles_agree_with_brute_force() {
    let planet = planet("luna");
    let right = differences(&planet, 0.0);
    let share = |sorted: &[f64], q: f64| sorted[(q * (sorted.len() - 1) as f64) as usize];
    // The map does not know the ground between its samples: the median is off by half a degree, sites below crater rims by two.
    assert!(share(&right, 0.5) < 0.01 && share(&right, 0.95) < 0.04, "{} {}", share(&right, 0.5), share(&right, 0.95));
    let turned = differences(&planet, 1.5);
    let medians = [share(&right, 0.5), share(&turned, 0.5)];
    assert!(medians[1] > 2.0 * medians[0], "any azimuth would do: {medians:?}");
}

#[test]
fn neighbours_agree_where_they_meet() {
    let planet = planet("terra");
    let (ground, known) = (planet.ground(), KnownSurroundings::default());
    let row = CELLS as usize + 1;
    for level in [3u8, 8, 13] {
        let id = PatchId::containing(direction_at(36.62, 106.05), level);
        // The neighbour on the same face, on whichever side it is.
        let (other, own, its) = if id.x.is_multiple_of(2) {
            (PatchId { x: id.x + 1, ..id }, row - 1, 0)
        } else {
            (PatchId { x: id.x - 1, ..id }, 0, row - 1)
        };
        assert!(Side::ALL.iter().any(|&side| id.neighbour(side) == other));
        let sun = low_sun(id.centre(), 0.7);
        let [a, b] = [id, other].map(|id| HorizonMap::new(&ground, id, sun, &mut known.sampled(&ground)));
        for y in 0..row {
            for (a, b) in [(&a.horizon, &b.horizon), (&a.sky, &b.sky)] {
                let (a, b) = (a[y * row + own], b[y * row + its]);
                assert!((a - b).abs() < 2e-3, "level {level}, row {y}: {a} and {b}");
            }
        }
        // The negative control: one row farther on, the horizons differ by more.
        let apart = (1..row).map(|y| (a.horizon[y * row + own] - b.horizon[(y - 1) * row + its]).abs()).fold(0.0, f32::max);
        assert!(apart > 2e-3, "level {level}: horizons of other rows agree too, within {apart}");
    }
}

#[test]
fn flat_ground_casts_no_shadow_on_itself() {
    let mut recipe = Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/luna.toml")).unwrap();
    recipe.layers.clear();
    let planet = Planet::from_recipe(recipe, CELLS).unwrap();
    for level in [0u8, 4, 15] {
        let id = PatchId::containing(DVec3::new(0.3, 0.8, 0.4), level);
        let (ground, known) = (planet.ground(), KnownSurroundings::default());
        let map = HorizonMap::new(&ground, id, low_sun(id.centre(), 2.0), &mut known.sampled(&ground));
        assert!(map.horizon.iter().all(|&h| (-0.02..=1e-4).contains(&h)), "level {level}");
        assert!(map.sky.iter().all(|&sky| sky > 0.999), "level {level}");
    }
}
