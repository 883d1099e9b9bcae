//! The builder on single patches: every vertex collapses, has a certified wake distance, and wakes after those that it needs.

use crate::common::TestField;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::ground::HeightGrid;
use terrane_planet::mesh::border_rules::BorderRules;
use terrane_planet::mesh::builder::{build, Faults, Hierarchy};
use terrane_planet::mesh::surface::Surface;

const KAPPA: f64 = 0.003;

fn build_patch(field: &TestField, cells: u32, id: PatchId) -> (Surface, Hierarchy) {
    let ground = field.ground(cells);
    let grid = HeightGrid::sample(&ground, id);
    let surface = Surface::new(&ground, &grid);
    let rules = BorderRules::new(&ground, &grid, KAPPA);
    let hierarchy = build(&surface, rules, KAPPA);
    (surface, hierarchy)
}

#[test]
fn no_vertex_is_stuck_or_uncertified() {
    for (seed, ridged) in [(1, false), (2, true), (3, true)] {
        for roughness in [0.003, 0.03, 0.15] {
            let field = TestField { radius: 30_000.0, roughness, ridged, seed };
            for level in [0, 1, 3, 7] {
                let id = PatchId::containing(direction_at(f64::from(seed) * 17.0, 40.0 + 10.0 * f64::from(seed)), level);
                let (_, hierarchy) = build_patch(&field, 32, id);
                assert_eq!(hierarchy.faults, Faults::default(), "seed {seed} roughness {roughness} {id}");
            }
        }
    }
}

#[test]
fn a_full_size_patch_builds() {
    let field = TestField { radius: 6_371_000.0, roughness: 0.002, ridged: true, seed: 9 };
    for level in [2, 10, 16] {
        let id = PatchId::containing(direction_at(46.0, 7.0), level);
        let start = std::time::Instant::now();
        let (surface, hierarchy) = build_patch(&field, 128, id);
        let always = hierarchy.wake.iter().filter(|w| w.distance().is_infinite()).count();
        println!(
            "level {level}: {:.0} ms for {} vertices, {always} always awake",
            start.elapsed().as_secs_f64() * 1e3,
            surface.len()
        );
        assert_eq!(hierarchy.faults, Faults::default());
        assert!(always < 64);
    }
}
