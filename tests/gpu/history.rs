//! Earlier frames leave no state: one view has the same mesh and the same picture whatever the viewer saw before.

use crate::harness::{device, planet_file};
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::Arc;
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::vulkan::Context;
use terrane_planet::draw::layout::VERTEX_BITS;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;

/// Size of the pictures.
const SIZE: [u32; 2] = [320, 180];

const LOOK: Look = Look::daylight(DVec3::new(0.8, 0.6, 0.0));

/// A viewer over the corner of a face, where patches are finest.
#[derive(Clone, Copy)]
struct Viewpoint {
    altitude: f64,
    heading: f64,
    fov: f64,
    tolerance: f64,
    /// The direction of the site below, before it is normalised.
    over: DVec3,
}

const GOAL: Viewpoint = Viewpoint { altitude: 400.0, heading: 40.0, fov: 0.9, tolerance: 0.5, over: DVec3::ONE };

impl Viewpoint {
    fn view(&self, scene: &Scene) -> View {
        let planet = scene.planet();
        let site = self.over.normalize();
        let position = planet.position_above(site, self.altitude);
        View::new(Camera::looking(position, self.heading, -25.0, self.fov, SIZE), &planet.lattice, planet.cells, self.tolerance)
    }
}

/// Viewpoints on the way to the goal, and how many patches each frame uploads.
fn way(name: &str) -> (Vec<Viewpoint>, usize) {
    match name {
        "at once" => (vec![], 0),
        // The height halves every frame, faster than patches arrive.
        "fall" => ((0..10).map(|k| Viewpoint { altitude: GOAL.altitude * f64::from(1 << (10 - k)), ..GOAL }).collect(), 1),
        "slow fall" => {
            ((1..20).rev().map(|k| Viewpoint { altitude: GOAL.altitude * (1.0 + 0.002 * f64::from(k)), ..GOAL }).collect(), 64)
        }
        "from below" => ((1..8).map(|k| Viewpoint { altitude: GOAL.altitude * f64::from(k) / 8.0, ..GOAL }).collect(), 64),
        "turn and zoom" => {
            let viewpoint = |k: i32| Viewpoint { heading: 40.0 + 30.0 * f64::from(k), fov: 0.2 + 0.1 * f64::from(k), ..GOAL };
            ((0..8).map(viewpoint).collect(), 3)
        }
        "other tolerances" => ([4.0, 0.1, 1.0].map(|tolerance| Viewpoint { tolerance, ..GOAL }).to_vec(), 64),
        "across the planet" => {
            let over = [DVec3::NEG_ONE, DVec3::new(-1.0, 1.0, 0.3), DVec3::new(1.0, 1.0, 0.8)];
            (over.map(|over| Viewpoint { over, ..GOAL }).to_vec(), 8)
        }
        _ => panic!("no way is called {name}"),
    }
}

/// The mesh and the picture of a view.
#[derive(PartialEq)]
pub(crate) struct Shown {
    /// Triangles by patch, with the bits of the drawn positions of their corners.
    pub(crate) triangles: BTreeSet<(PatchId, [[u32; 3]; 3])>,
    pub(crate) pixels: Vec<u8>,
}

pub(crate) fn show(scene: &Scene, headless: &mut Headless, view: &View, cut: &terrane_planet::draw::cut::Cut) -> Shown {
    let report = headless.render(scene, view, cut, &LOOK).unwrap();
    let selection = headless.read_selection(&report).unwrap();
    let named = |t: &[u32; 3]| {
        let number = (t[0] >> VERTEX_BITS) as usize;
        let first = report.tables.patches[number].resolve_offset;
        let position =
            |v: u32| selection.drawn_positions[(first + (v & ((1 << VERTEX_BITS) - 1))) as usize].position.map(f32::to_bits);
        (report.tables.leaves[number].id, t.map(position))
    };
    Shown { triangles: selection.triangles.iter().map(named).collect(), pixels: headless.pixels().unwrap() }
}

/// Draws all frames of a way with a new scene, then the goal.
fn arrive(context: &Arc<Context>, name: &str) -> Shown {
    let mut scene = Scene::open(context, planet_file(), SceneOptions::default()).unwrap();
    let mut headless = Headless::new(context, (SIZE[0], SIZE[1])).unwrap();
    let (viewpoints, uploads) = way(name);
    for viewpoint in viewpoints {
        let view = viewpoint.view(&scene);
        let cut = scene.update(&view, uploads).unwrap();
        headless.render(&scene, &view, &cut, &LOOK).unwrap();
    }
    let goal = GOAL.view(&scene);
    let cut = scene.settle(&goal).unwrap();
    show(&scene, &mut headless, &goal, &cut)
}

#[test]
fn a_view_is_the_same_whatever_came_before_it() {
    let Some(context) = device() else { return };
    let expected = arrive(&context, "at once");
    assert!(expected.triangles.len() > 200, "{} triangles prove little", expected.triangles.len());
    for name in ["fall", "slow fall", "from below", "turn and zoom", "other tolerances", "across the planet"] {
        let found = arrive(&context, name);
        let apart = found.triangles.symmetric_difference(&expected.triangles).count();
        let pixels = found.pixels.chunks(4).zip(expected.pixels.chunks(4)).filter(|(a, b)| a != b).count();
        assert_eq!((apart, pixels), (0, 0), "{name}: triangles and pixels that differ");
    }
}

#[test]
fn the_comparison_finds_a_moved_viewer_and_missing_patches() {
    let Some(context) = device() else { return };
    let mut scene = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    let mut headless = Headless::new(&context, (SIZE[0], SIZE[1])).unwrap();
    let goal = GOAL.view(&scene);
    let early = scene.update(&goal, 0).unwrap();
    let early = show(&scene, &mut headless, &goal, &early);
    let cut = scene.settle(&goal).unwrap();
    let settled = show(&scene, &mut headless, &goal, &cut);
    let aside = Viewpoint { altitude: GOAL.altitude * 1.001, ..GOAL }.view(&scene);
    let cut = scene.settle(&aside).unwrap();
    let aside = show(&scene, &mut headless, &aside, &cut);
    for other in [early, aside] {
        assert!(other.triangles != settled.triangles && other.pixels != settled.pixels);
    }
}
