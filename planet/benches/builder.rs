//! The patch builder by itself: triangles a second on one core and on two, how many vertices dependencies keep awake beyond what
//! each alone would ask for, and what borders cost. Prints Markdown.
//!
//! `cargo bench -p terrane-planet --bench builder`

use glam::DVec3;
use std::path::Path;
use std::time::Instant;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::ground::{Ground, HeightGrid};
use terrane_planet::mesh::border_rules::BorderRules;
use terrane_planet::mesh::build_patch;
use terrane_planet::mesh::builder::{build, Hierarchy};
use terrane_planet::mesh::certificate::KAPPA_BUILD;
use terrane_planet::mesh::surface::Surface;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;

const CELLS: u32 = 128;

/// Land with mountains, lowland, and mostly sea; latitude and longitude in degrees.
const SITES: [(f64, f64); 3] = [(36.62, 106.05), (10.0, 20.0), (-30.0, 140.0)];

fn planet(name: &str) -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recipes/{name}.toml"));
    let recipe = Recipe::load(&path).expect("a shipped recipe");
    Planet::from_recipe(recipe, CELLS).expect("a shipped recipe")
}

fn patches(levels: &[u8]) -> Vec<PatchId> {
    let at = |(latitude, longitude), level| PatchId::containing(direction_at(latitude, longitude), level);
    SITES.into_iter().flat_map(|site| levels.iter().map(move |&level| at(site, level))).collect()
}

/// Milliseconds of the best of a few runs.
fn best_of<T>(runs: usize, mut work: impl FnMut() -> T) -> f64 {
    let mut time = || {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..runs).map(|_| time()).fold(f64::INFINITY, f64::min)
}

fn speed(planet: &Planet) {
    println!("| patch | surface ms | border rules ms | collapses ms | triangles/s, all three |\n|---|---|---|---|---|");
    let ground = planet.ground();
    let (mut triangles, mut milliseconds) = (0.0, 0.0);
    for id in patches(&[1, 5, 9, 13, 17]) {
        let grid = HeightGrid::sample(&ground, id);
        let surface = Surface::new(&ground, &grid);
        let times = [
            best_of(9, || Surface::new(&ground, &grid)),
            best_of(9, || BorderRules::new(&ground, &grid, KAPPA_BUILD)),
            // Without the rules, which the builder uses up.
            best_of(9, || build(&surface, BorderRules::new(&ground, &grid, KAPPA_BUILD), KAPPA_BUILD)),
        ];
        let [surface, rules, both] = times;
        let count = f64::from(2 * CELLS * CELLS);
        println!("| {id} | {surface:.2} | {rules:.2} | {:.2} | {:.0} |", both - rules, count / (surface + both) * 1e3);
        (triangles, milliseconds) = (triangles + count, milliseconds + surface + both);
    }
    println!("| all | | | | {:.0} |\n", triangles / milliseconds * 1e3);
}

fn threads(planet: &Planet) {
    let ids = patches(&[1, 3, 5, 7, 9, 11, 13, 15, 17]);
    let ground = Ground { kept: None, ..planet.ground() };
    let all =
        |share: &[PatchId]| share.iter().for_each(|&id| drop(std::hint::black_box(build_patch(&ground, &planet.terrain, id))));
    let one = best_of(3, || all(&ids));
    let (first, second): (Vec<_>, Vec<_>) = ids.iter().enumerate().partition(|(k, _)| k % 2 == 0);
    let halves = [first, second].map(|half| half.into_iter().map(|(_, &id)| id).collect::<Vec<_>>());
    let two = best_of(3, || std::thread::scope(|scope| halves.iter().for_each(|half| drop(scope.spawn(|| all(half))))));
    println!("{} whole patches: {one:.0} ms on one thread, {two:.0} ms on two: {:.2} times\n", ids.len(), one / two);
}

/// Vertices awake for cameras from close above a patch to where the last ones fall asleep.
struct Awake {
    built: f64,
    alone: f64,
    free: f64,
    free_alone: f64,
}

fn count_awake(surface: &Surface, hierarchy: &Hierarchy, eye: DVec3, scale: f64) -> [f64; 2] {
    let mut counts = [0.0; 2];
    for v in 0..surface.len() {
        let distance = eye.distance(surface.positions[v].as_dvec3());
        let wake = hierarchy.wake[v].distance();
        let alone = if wake.is_infinite() { wake } else { f64::from(hierarchy.demand[v]) };
        counts[0] += f64::from(u8::from(distance < scale * wake));
        counts[1] += f64::from(u8::from(distance < scale * alone));
    }
    counts
}

fn awake(planet: &Planet, id: PatchId, scale: f64) -> Awake {
    let ground = planet.ground();
    let grid = HeightGrid::sample(&ground, id);
    let surface = Surface::new(&ground, &grid);
    let built = build(&surface, BorderRules::new(&ground, &grid, KAPPA_BUILD), KAPPA_BUILD);
    let free = build(&surface, BorderRules::free(CELLS), KAPPA_BUILD);
    let middle = surface.positions[surface.len() / 2].as_dvec3();
    let corner = surface.positions[CELLS as usize].as_dvec3();
    let mut sum = Awake { built: 0.0, alone: 0.0, free: 0.0, free_alone: 0.0 };
    for camera in 0..12 {
        let height = surface.distance(0, CELLS) * scale * 0.05 * 400f64.powf(f64::from(camera) / 11.0);
        let eye = middle + middle.normalize() * height + (corner - middle) * (f64::from(camera % 3) - 1.0);
        let [a, b] = count_awake(&surface, &built, eye, scale);
        let [c, d] = count_awake(&surface, &free, eye, scale);
        sum = Awake { built: sum.built + a, alone: sum.alone + b, free: sum.free + c, free_alone: sum.free_alone + d };
    }
    sum
}

fn overhead(names: &[&str]) {
    println!("| planet | tolerance | awake over each vertex alone (worst patch) | over a patch without borders (worst patch) |\n|---|---|---|---|");
    for name in names {
        let planet = planet(name);
        for (label, scale) in [("κ₀", 1.0), ("κ₀/4", 4.0)] {
            let sums: Vec<Awake> = patches(&[2, 6, 10, 14]).into_iter().map(|id| awake(&planet, id, scale)).collect();
            let total = |of: fn(&Awake) -> f64| sums.iter().map(of).sum::<f64>();
            let worst = |of: fn(&Awake) -> f64| sums.iter().map(of).fold(0.0, f64::max);
            println!(
                "| {name} | {label} | {:.3} ({:.3}) | {:.3} ({:.3}) |",
                total(|a| a.built) / total(|a| a.alone),
                worst(|a| a.built / a.alone),
                total(|a| a.built) / total(|a| a.free),
                worst(|a| a.built / a.free),
            );
            let free = total(|a| a.free) / total(|a| a.free_alone);
            println!("| {name}, no borders | {label} | {free:.3} | |");
        }
    }
}

fn main() {
    let terra = planet("terra");
    speed(&terra);
    threads(&terra);
    overhead(&["terra", "luna"]);
}
