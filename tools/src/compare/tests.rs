//! Every method draws a surface without holes, exact for a tolerance near zero and coarser with a larger knob; and the measurement finds
//! faults.

use super::tuning::{measure, tune, Aim};
use super::*;
use glam::DVec3;
use std::collections::HashMap;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::HeightGrid;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;

/// A small planet, all patches down to a level.
pub(super) fn small_setting(cells: u32, levels: u8) -> Setting {
    let recipe = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let planet = Planet::from_recipe(Recipe::load(&recipe).unwrap(), cells).unwrap();
    let mut ids: Vec<PatchId> = PatchId::roots().collect();
    let mut at = 0;
    while at < ids.len() {
        if ids[at].level < levels {
            ids.extend(ids[at].children().into_iter().flatten());
        }
        at += 1;
    }
    let ground = planet.ground();
    let build = |id| (id, PatchMesh::build(&ground, &HeightGrid::sample(&ground, id)).0);
    let meshes: HashMap<PatchId, PatchMesh> = ids.into_iter().map(build).collect();
    let tree = planet.tree(meshes.values().map(|m| (m.id, m.facts)));
    Setting::new(tree, Box::new(move |id| Ok(meshes[&id].clone())))
}

fn site() -> DVec3 {
    DVec3::new(1.0, 0.9, 0.8).normalize()
}

/// Cameras in orbit and at two lower altitudes above the site, which look ahead.
fn cameras(setting: &Setting) -> Vec<Camera> {
    let radius = setting.tree.lattice.radius * setting.tree.lattice.unit;
    let looks = [(2.0, -90.0), (0.1, -40.0), (0.04, -10.0)];
    looks.map(|(radii, pitch)| Camera::looking(site() * radius * (1.0 + radii), 20.0, pitch, 0.9, [640, 360])).into()
}

struct Scene {
    setting: Setting,
    viewpoints: Vec<Viewpoint>,
}

impl Scene {
    fn new() -> Scene {
        let setting = small_setting(16, 3);
        let viewpoints = viewpoints(&setting, &cameras(&setting), 1.0, Effort { pixels: 2048, block: 1 }).unwrap();
        assert!(count_probes(&viewpoints) > 10_000);
        Scene { setting, viewpoints }
    }

    fn measure(&self, method: &dyn Method, knob: f64) -> Measured {
        measure(&self.setting, &self.viewpoints.iter().collect::<Vec<_>>(), method, knob).unwrap()
    }

    fn methods(&self) -> Vec<Box<dyn Method>> {
        FAMILIES.iter().flat_map(|family| family(&self.setting).unwrap()).collect()
    }
}

#[test]
fn methods_leave_no_holes_and_coarsen_with_the_knob() {
    let scene = Scene::new();
    let methods = scene.methods();
    assert!(methods.len() > 15);
    for method in methods {
        let drawn = [0.5, 1.0, 2.0, 8.0].map(|knob| scene.measure(method.as_ref(), knob));
        let triangles = drawn.each_ref().map(|m| m.submitted);
        // Not to the triangle: a coarser patch of the cut may need a few more than its children did.
        assert!(triangles.is_sorted_by(|fine, coarse| fine + fine / 50 >= *coarse), "{}: {triangles:?}", method.variant());
        assert!(triangles[3] < triangles[0], "{}: {triangles:?}", method.variant());
        let missed = drawn.each_ref().map(|m| m.missed);
        assert_eq!(missed, [0; 4], "{}, {}", method.family(), method.variant());
    }
}

#[test]
fn methods_are_exact_where_nothing_may_be_off() {
    let scene = Scene::new();
    for method in scene.methods() {
        let (fine, coarse) = (scene.measure(method.as_ref(), 1e-6), scene.measure(method.as_ref(), 2.0));
        assert!(fine.max < 1e-3, "{}, {}: {} px", method.family(), method.variant(), fine.max);
        assert!(coarse.max > 0.2, "{}, {}: {} px", method.family(), method.variant(), coarse.max);
    }
}

#[test]
fn our_errors_stay_within_the_tolerance() {
    let scene = Scene::new();
    let ours = Ours::new();
    for (tolerance, ours) in [0.5, 1.0].into_iter().flat_map(|t| [(t, ours.without_geomorphs()), (t, Ours::new())]) {
        let most = scene.measure(&ours, tolerance).max / tolerance;
        assert!((0.3..=1.0).contains(&most), "{most} of {tolerance} px {}", ours.variant());
    }
}

/// Our surface lifted by `knob` thousandths of the planet's radius, without every `torn`th triangle.
struct Wrong {
    lifted: bool,
    torn: usize,
}

impl Method for Wrong {
    fn family(&self) -> &'static str {
        "wrong"
    }

    fn variant(&self) -> String {
        String::new()
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let scale = if self.lifted { 1.0 + knob * 1e-3 } else { 1.0 };
        Ours::new().patches(setting, &setting.view(camera, 1e-6), |drawn| {
            let position = |v: u32| glam::IVec3::from_array(drawn.vertices[v as usize].position).as_dvec3() * scale;
            let kept = drawn.triangles.iter().enumerate().filter(|(k, _)| self.torn == 0 || k % self.torn > 0);
            let kept: Vec<[u32; 3]> = kept.map(|(_, triangle)| *triangle).collect();
            sheet.add(drawn.id.face, drawn.vertices.len(), position, &kept);
        })
    }
}

#[test]
fn missing_triangles_are_noticed() {
    let scene = Scene::new();
    assert_eq!(scene.measure(&Wrong { lifted: false, torn: 0 }, 1.0).missed, 0);
    assert!(scene.measure(&Wrong { lifted: false, torn: 20 }, 1.0).missed > 100);
}

#[test]
fn a_lifted_surface_is_as_far_off_as_it_was_lifted() {
    let scene = Scene::new();
    let (setting, viewpoint) = (&scene.setting, &scene.viewpoints[2]);
    let found = measure(setting, &[viewpoint], &Wrong { lifted: true, torn: 0 }, 1.0).unwrap();
    let expected = |probe: &probes::Probe| 1e-3 * probe.radius * probe.pixels_a_unit;
    let most = viewpoint.probes.faces.iter().flat_map(|tree| &tree.probes).map(expected).fold(0.0, f64::max);
    assert!((found.max / most - 1.0).abs() < 1e-3, "{} px, expected {most}", found.max);
}

#[test]
fn the_knob_with_the_target_error_is_found() {
    let scene = Scene::new();
    let viewpoints: Vec<&Viewpoint> = scene.viewpoints.iter().collect();
    for (equal, target) in [(Equal::Max, 1.0), (Equal::P999, 0.25)] {
        let aim = Aim { equal, target, first: 1.0, most: f64::INFINITY };
        let found = tune(&scene.setting, &viewpoints, &Wrong { lifted: true, torn: 0 }, aim).unwrap().unwrap();
        assert!((found.error(equal) / target - 1.0).abs() <= 0.03, "{} px", found.error(equal));
        let too_many = Aim { most: 0.0, first: 1e3, ..aim };
        assert!(tune(&scene.setting, &viewpoints, &Wrong { lifted: true, torn: 0 }, too_many).unwrap().is_none());
    }
}

#[test]
fn the_finest_surface_passes_through_the_finest_samples() {
    let setting = small_setting(16, 2);
    let id = PatchId::containing(site(), 2);
    let positions = setting.positions(id).unwrap();
    for k in [20, 100, 150, 200] {
        let sample = positions[k].as_dvec3();
        let found = setting.finest(sample.normalize()).unwrap().unwrap();
        assert!(found.distance(sample) < 1e-3, "{found} instead of {sample}");
        let between = (sample + positions[k + 1].as_dvec3()) / 2.0;
        let found = setting.finest(between.normalize()).unwrap().unwrap();
        assert!(found.distance(between) < 2.0, "{found} instead of {between}");
    }
}

/// Twice the area of triangles of a grid, in cells.
pub(super) fn doubled_area(cells: u32, triangles: &[[u32; 3]]) -> i64 {
    let column_and_row = |v: u32| (i64::from(v % (cells + 1)), i64::from(v / (cells + 1)));
    let area = |t: &[u32; 3]| {
        let [(ax, ay), (bx, by), (cx, cy)] = t.map(column_and_row);
        ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)).abs()
    };
    triangles.iter().map(area).sum()
}

/// Directed edges off the rim of a grid that no opposite edge cancels.
pub(super) fn open_edges_inside(cells: u32, triangles: &[[u32; 3]]) -> usize {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    let on_rim = |&(a, b): &(u32, u32)| {
        let [(ai, aj), (bi, bj)] = [a, b].map(|v| (v % (cells + 1), v / (cells + 1)));
        (ai == bi && ai % cells == 0) || (aj == bj && aj % cells == 0)
    };
    edges.iter().filter(|(edge, count)| **count != 0 && !on_rim(edge)).count()
}
