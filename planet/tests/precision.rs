//! Precision near the ground: on an Earth with samples 0.6 m apart, a camera 2 m above the ground moves by steps of a millimetre. Where the
//! single-precision stages put every vertex on the screen is compared with the same in f64: how far off, and whether it jitters.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use glam::{DVec3, IVec3, Mat4, Vec2, Vec3};
use std::collections::HashMap;
use std::path::Path;
use std::sync::OnceLock;
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::{direction, direction_at, ONE};
use terrane_planet::mesh::wake::Wake;
use terrane_planet::planet::Planet;
use terrane_planet::query::{KnownGround, PatchGrid};
use terrane_planet::recipe::Recipe;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{on_sides, select, Selected};
use terrane_planet::verify::{SurfaceCheck, SurfaceReport};

const SIZE: [u32; 2] = [1280, 720];
const LEVEL: u8 = 17;
/// Length of a step in metres.
const STEP: f64 = 1e-3;
const STEPS: usize = 24;
/// Height of the eye in metres.
const HEIGHT: f64 = 2.0;
/// Nearest vertices compared, in metres along the view axis.
const NEAREST: f64 = 0.5;
/// How far off a vertex may be on the screen, in pixels.
const OFF: f64 = 0.001;
/// How unsteadily it may move: how far off it is in one step, from the mean of how far off it is in the steps before and after, twice. In
/// pixels.
const JITTER: f64 = 0.002;

/// The four finest patches of one parent, and the site of the viewer on them.
struct Site {
    planet: Planet,
    patches: Vec<LoadedPatch>,
    ground: KnownGround,
    up: DVec3,
}

impl Site {
    fn new(towards: DVec3) -> Site {
        let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/terra.toml");
        let planet = Planet::from_recipe(Recipe::load(&recipe).unwrap(), 128).unwrap();
        let parent = PatchId::containing(towards, LEVEL - 1);
        let meshes = parent.children().unwrap().map(|id| planet.build(id).0);
        let mut ground = KnownGround::new(planet.lattice, planet.cells);
        let above = std::iter::successors(Some(parent), |id| id.parent()).flat_map(|id| id.children().unwrap());
        above.for_each(|id| assert!(ground.insert(PatchGrid::sample(&planet.ground(), id))));
        let patches = meshes.into_iter().map(|mesh| LoadedPatch::new(mesh, &planet.lattice)).collect();
        Site { up: parent.centre(), planet, patches, ground }
    }

    /// The camera after some steps, [`HEIGHT`] above where it began.
    fn camera(&self, heading: f64, steps: usize) -> Camera {
        let datum = self.planet.recipe.radius + self.ground.height_at(self.up).unwrap().height;
        let start = Camera::looking(self.up * (datum + HEIGHT), heading, -20.0, 0.9, SIZE);
        let along = (start.forward - self.up * start.forward.dot(self.up)).normalize();
        Camera { position: start.position + (along * 0.8 + start.right() * 0.6) * (STEP * steps as f64), ..start }
    }

    fn view(&self, heading: f64, steps: usize) -> View {
        View::new(self.camera(heading, steps), &self.planet.lattice, self.planet.cells, 1.0)
    }
}

/// Pixel coordinates, from the picture's corner, of a position in clip space.
fn pixels(x: f64, y: f64, w: f64) -> [f64; 2] {
    [(x / w * 0.5 + 0.5) * f64::from(SIZE[0]), (y / w * 0.5 + 0.5) * f64::from(SIZE[1])]
}

/// As `draw.vert` does it, in single precision.
fn drawn(view: &View, position: Vec3) -> [f64; 2] {
    let clip = Mat4::from_cols_array_2d(&view.gpu.clip) * (position * view.gpu.unit).extend(1.0);
    let screen = (Vec2::new(clip.x, clip.y) / clip.w).as_dvec2();
    pixels(screen.x, screen.y, 1.0)
}

/// Pixel coordinates of a point in lattice units from the eye, in f64; `None` outside of the picture.
fn seen(view: &View, point: DVec3) -> Option<[f64; 2]> {
    let camera = &view.camera;
    let point = point * f64::from(view.gpu.unit);
    let (h, v) = camera.half_extents();
    let (x, y, w) = (point.dot(camera.right()) / h, -point.dot(camera.up) / v, point.dot(camera.forward));
    (w > NEAREST && x.abs() < w && y.abs() < w).then(|| pixels(x, y, w))
}

/// The drawn position of an awake vertex in lattice units from the eye, geomorphs included, in f64.
fn exact(view: &View, vertices: &[PatchVertex], v: usize) -> DVec3 {
    let relative = |v: usize| IVec3::from_array(vertices[v].position).as_dvec3() - view.eye;
    let own = relative(v);
    let wake = Wake::from_code((vertices[v].grid_wake >> 16) as u16);
    if wake == Wake::ALWAYS {
        return own;
    }
    let outside = view.planes.iter().map(|plane| plane.dot(own)).fold(0.0, f64::max);
    let slide = ((own.length() + view.falloff * outside) / wake.distance() - view.scale) / (view.reach - view.scale);
    own.lerp(relative(vertices[v].parent() as usize), slide.clamp(0.0, 1.0))
}

/// How far off vertices are along a path, and how much they jitter, in pixels; and how many were compared.
#[derive(Debug, Default)]
struct Precision {
    off: f64,
    jitter: f64,
    compared: usize,
}

fn measure(site: &Site, heading: f64, position: &dyn Fn(&View, &PatchVertex, [f32; 3]) -> Vec3) -> Precision {
    let mut found = Precision::default();
    // The differences of each vertex in the latest two steps.
    let mut before: HashMap<(usize, usize), [Option<[f64; 2]>; 2]> = HashMap::new();
    for step in 0..STEPS {
        let view = site.view(heading, step);
        for (k, patch) in site.patches.iter().enumerate() {
            let Selected { awake, drawn_positions } = select(&view.gpu, &patch.vertices, 0);
            for v in (0..drawn_positions.len()).filter(|v| awake[v / 32] >> (v % 32) & 1 == 1) {
                let Some(truth) = seen(&view, exact(&view, &patch.vertices, v)) else { continue };
                let drawn = drawn(&view, position(&view, &patch.vertices[v], drawn_positions[v].position));
                let off = [drawn[0] - truth[0], drawn[1] - truth[1]];
                let [one, two] = before.insert((k, v), [Some(off), None]).unwrap_or_default();
                before.insert((k, v), [Some(off), one]);
                found.off = found.off.max(off[0].hypot(off[1]));
                if let (Some(one), Some(two)) = (one, two) {
                    let second = [0, 1].map(|axis| off[axis] - 2.0 * one[axis] + two[axis]);
                    found.jitter = found.jitter.max(second[0].hypot(second[1]));
                    found.compared += 1;
                }
            }
        }
    }
    found
}

/// A coast, a face corner and a pole.
fn sites() -> &'static [Site; 3] {
    static SITES: OnceLock<[Site; 3]> = OnceLock::new();
    SITES.get_or_init(|| [direction_at(36.62, 106.05), direction(IVec3::new(ONE, ONE, ONE)), DVec3::Z].map(Site::new))
}

#[test]
fn nothing_jitters_or_swims_a_metre_from_the_eye() {
    for site in sites() {
        for heading in [20.0, 200.0] {
            let found = measure(site, heading, &|_, _, position| Vec3::from_array(position));
            assert!(found.compared > 1000, "{found:?}");
            assert!(found.off < OFF && found.jitter < JITTER, "{found:?}");
        }
    }
}

#[test]
fn single_precision_without_the_lattice_is_noticed() {
    let site = &sites()[0];
    // Single precision relative to the planet's centre has steps of half a metre here.
    let naive =
        |view: &View, vertex: &PatchVertex, _: [f32; 3]| IVec3::from_array(vertex.position).as_vec3() - view.eye.as_vec3();
    let found = measure(site, 20.0, &naive);
    assert!(found.off > 10.0, "{found:?}");
    // An eye that is rounded to the lattice stays where it is for some frames, then jumps.
    let jumps = |view: &View, _: &PatchVertex, position: [f32; 3]| Vec3::from_array(position) + Vec3::from_array(view.gpu.offset);
    let found = measure(site, 20.0, &jumps);
    assert!(found.off > 100.0 * OFF && found.jitter > 100.0 * JITTER, "{found:?}");
}

/// Sides of one of four siblings that lie on the border of all four together; bits as in [`Side::bit`].
fn outer_sides(child: usize) -> u32 {
    let right = if child % 2 == 1 { Side::Right } else { Side::Left };
    let upper = if child / 2 == 1 { Side::Top } else { Side::Bottom };
    u32::from(right.bit() | upper.bit())
}

/// Faults of the surface of the four patches, and the number of edges on its rim, which are open because the surface ends there.
/// `change` may move vertices of a patch first.
fn surface(site: &Site, view: &View, change: &dyn Fn(usize, &mut [PatchVertex])) -> (SurfaceReport, usize) {
    let (mut check, mut rim) = (SurfaceCheck::default(), 0);
    for (k, patch) in site.patches.iter().enumerate() {
        let work = patch.reach.work(view);
        let mut vertices = patch.vertices[..work.vertices as usize].to_vec();
        change(k, &mut vertices);
        let Selected { awake, drawn_positions } = select(&view.gpu, &vertices, 0);
        let triangles = emit(&view.gpu, &patch.triangles(&work), &resolve(&vertices, &awake), &drawn_positions);
        check.add(&vertices, &drawn_positions, &triangles);
        let on = |v: u32, side: u32| on_sides(vertices[v as usize].grid(), site.planet.cells, side);
        let sides = Side::ALL.map(|side| u32::from(side.bit()) & outer_sides(k));
        let on_rim = |a, b| sides.iter().any(|&side| on(a, side) && on(b, side));
        let edges = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        rim += edges.filter(|&(a, b)| on_rim(a, b)).count();
    }
    (check.finish(), rim)
}

#[test]
fn nothing_cracks_between_the_finest_patches() {
    for site in sites() {
        for step in [0, 7, 19] {
            let view = site.view(20.0, step).without_culling();
            let (report, rim) = surface(site, &view, &|_, _| ());
            assert!(report.triangles > 500 && rim > 8, "{report:?}");
            assert_eq!((report.cracks, report.flipped, report.degenerate), (rim, 0, 0), "{report:?}");
        }
    }
}

#[test]
fn a_corner_eight_millimetres_off_is_a_crack() {
    let site = &sites()[0];
    let view = site.view(20.0, 0).without_culling();
    let shift = |k: usize, vertices: &mut [PatchVertex]| {
        // The vertex at the corner that all four patches share.
        let shared = vertices.iter_mut().find(|v| v.grid() == (site.planet.cells + 1).pow(2) - 1);
        if let Some(vertex) = shared.filter(|_| k == 0) {
            vertex.position[0] += 1;
        }
    };
    let (report, rim) = surface(site, &view, &shift);
    assert!(report.cracks > rim, "{report:?}, {rim}");
}
