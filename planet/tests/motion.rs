//! Geomorphs: the drawn surface moves in proportion to the viewer's motion, and never jumps.
//!
//! Between two frames the surface is probed along rays from the planet's centre: through every drawn vertex of both frames, and through
//! random points, inside both pictures. A motion is the radial distance between the two hits, in pixels as the camera sees it.

use crate::common::TestField;
use crate::whole_planet::{planet, Planet};
use glam::{DQuat, DVec3};
use std::collections::{HashMap, HashSet};
use terrane_planet::draw::cut::{cut, is_visible, Leaf};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::random::Random;
use terrane_planet::mesh::wake::MORPH_REACH;
use terrane_planet::query::rays::patch_surface::PatchSurface;
use terrane_planet::query::rays::Ray;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::position::exact_position;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::select;

const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };

/// Finest level of the test planet.
const FINEST: u8 = 5;

/// Random points a patch and pair of frames.
const RANDOM_POINTS: usize = 20;

/// Motions below so many pixels need not halve. Turns on the spot cause few larger ones: the weights of vertices in the picture follow
/// their distance alone, which does not change, and vertices that come into the picture end their geomorphs in the middle of a step.
const SMALLEST: f64 = 1e-3;

/// Largest distance between two frames, as a share of the viewer's height. A geomorph lasts for a thirtieth of the vertex's distance.
const STEP: f64 = 1.0 / 500.0;

/// What is drawn of one patch.
struct DrawnPatch {
    leaf: Leaf,
    weights: Vec<f32>,
    surface: PatchSurface<DVec3>,
    /// Corners of triangles, and random points on triangles.
    points: Vec<DVec3>,
}

/// One frame: the patches that may be in the picture, and all of the cut.
struct Frame {
    view: View,
    patches: HashMap<PatchId, DrawnPatch>,
    leaves: Vec<Leaf>,
}

impl Frame {
    fn new(planet: &Planet, view: View, resident: &dyn Fn(PatchId) -> bool) -> Frame {
        let leaves = cut(&planet.tree, &view, resident).leaves;
        let seen = |leaf: &&Leaf| planet.tree.get(leaf.id).is_some_and(|node| is_visible(&planet.tree, &view, &node.space));
        let patches = leaves.iter().filter(seen).map(|leaf| (leaf.id, drawn(planet, &view, leaf))).collect();
        Frame { view, patches, leaves }
    }

    /// Distance of the surface from the planet's centre; `None` where rounding puts a point beside the patch it lies on.
    fn radius(&self, through: DVec3) -> Option<f64> {
        let ids = (0..=FINEST).map(|level| PatchId::containing(through.normalize(), level));
        let patch = ids.filter_map(|id| self.patches.get(&id)).next()?;
        patch.surface.nearest(&Ray::radial(through))
    }
}

fn drawn(planet: &Planet, view: &View, leaf: &Leaf) -> DrawnPatch {
    let (patch, _) = &planet.patches[&leaf.id];
    let work = patch.reach.work(view);
    let vertices = &patch.vertices[..work.vertices as usize];
    let selected = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
    let resolved = resolve(vertices, &selected.awake);
    let triangles = emit(&view.gpu, &patch.triangles(&work), &resolved, &selected.drawn_positions);
    let position = |v: u32| exact_position(vertices, v, selected.drawn_positions[v as usize].weight);
    let corners: HashSet<u32> = triangles.iter().flatten().copied().collect();
    let mut points: Vec<DVec3> = corners.into_iter().map(position).collect();
    let mut random = Random::new(u64::from(leaf.id.x) << 20 | u64::from(leaf.id.y));
    for _ in 0..RANDOM_POINTS {
        let [a, b, c] = triangles[random.bits() as usize % triangles.len()].map(position);
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        points.push(a + (b - a) * u + (c - a) * v);
    }
    let surface = PatchSurface::of_drawn(vertices, &selected.drawn_positions, &triangles);
    let weights = selected.drawn_positions.iter().map(|drawn| drawn.weight).collect();
    DrawnPatch { leaf: *leaf, weights, surface, points }
}

/// The largest motion between two frames.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    pixels: f64,
    /// Largest motion as a share of what a geomorph may cause: one tolerance while the viewer moves by the geomorph's length.
    share_of_slide: f64,
    points: usize,
    cut_changed: bool,
}

impl Motion {
    fn or_larger(self, other: Motion) -> Motion {
        Motion {
            pixels: self.pixels.max(other.pixels),
            share_of_slide: self.share_of_slide.max(other.share_of_slide),
            points: self.points + other.points,
            cut_changed: self.cut_changed || other.cut_changed,
        }
    }
}

/// Probes what differs between two frames; `moved` is how far any point that the camera sees came or went, over its distance.
fn motion(a: &Frame, b: &Frame, moved: f64) -> Motion {
    let mut found = Motion { cut_changed: a.leaves != b.leaves, ..Motion::default() };
    for (one, other) in [(a, b), (b, a)] {
        for patch in one.patches.values() {
            let same = other.patches.get(&patch.leaf.id).is_some_and(|p| p.leaf == patch.leaf && p.weights == patch.weights);
            if !same {
                patch.points.iter().for_each(|&point| probe(a, b, point, moved, &mut found));
            }
        }
    }
    found
}

fn probe(a: &Frame, b: &Frame, point: DVec3, moved: f64, found: &mut Motion) {
    let seen = |view: &View| view.planes.iter().all(|plane| plane.dot(point - view.eye) <= 0.0);
    if !seen(&a.view) || !seen(&b.view) {
        return;
    }
    let (Some(first), Some(second)) = (a.radius(point), b.radius(point)) else { return };
    let pixels = (first - second).abs() / point.distance(a.view.eye) / a.view.camera.pixel_angle();
    let slide = a.view.tolerance * (1.0 + a.view.falloff) * moved / (MORPH_REACH - 1.0);
    found.pixels = found.pixels.max(pixels);
    found.share_of_slide = found.share_of_slide.max(pixels / slide);
    found.points += 1;
}

/// How a viewer moves: an approach straight down, a turn on the spot, a flight past.
#[derive(Clone, Copy, Debug)]
enum Path {
    Approach,
    Pan,
    FlyBy,
}

/// Where a path begins.
struct Viewpoint {
    site: DVec3,
    height: f64,
    /// Radians above the horizontal.
    pitch: f64,
    tolerance: f64,
    path: Path,
}

impl Viewpoint {
    /// The view `way` along the path: in heights of the viewer, or in radians of a turn.
    fn view(&self, planet: &Planet, way: f64, geomorphs: bool) -> View {
        let up = self.site;
        let ahead = up.any_orthonormal_vector();
        let base = up * (FIELD.radius + FIELD.at(up) + self.height);
        let (position, turn) = match self.path {
            Path::Approach => (base - up * (way * self.height), 0.0),
            // Distance outside the picture counts up to three times, which makes geomorphs as much shorter.
            Path::Pan => (base, way / 4.0),
            Path::FlyBy => (base + ahead.cross(up) * (way * self.height), 0.0),
        };
        let (pitch, turned) = (self.pitch, DQuat::from_axis_angle(up, turn));
        let (forward, above) = (ahead * pitch.cos() + up * pitch.sin(), up * pitch.cos() - ahead * pitch.sin());
        let camera = Camera { position, forward: turned * forward, up: turned * above, fov: 0.9, size: [1280, 720] };
        let view = View::new(camera, &planet.tree.lattice, planet.tree.cells, self.tolerance).without_culling();
        if geomorphs {
            view
        } else {
            view.without_geomorphs()
        }
    }

    /// Largest motion between neighbouring frames over `length`, of those without a change of the cut.
    fn largest_motion(&self, planet: &Planet, length: f64, step: f64, geomorphs: bool) -> Motion {
        let count = (length / step).round() as usize;
        let frame = |k: usize| Frame::new(planet, self.view(planet, k as f64 * step, geomorphs), &|_| true);
        let mut largest = Motion::default();
        let mut before = frame(0);
        for k in 1..=count {
            let now = frame(k);
            let found = motion(&before, &now, step);
            if !found.cut_changed {
                largest = largest.or_larger(found);
            }
            before = now;
        }
        largest
    }
}

/// Paths over several sites at several tolerances, all certified.
fn viewpoints(planet: &Planet) -> Vec<Viewpoint> {
    let sites = [DVec3::ONE, DVec3::new(1.0, 0.98, 0.9), DVec3::new(1.0, 0.2, 1.0), DVec3::new(-0.3, 0.5, 0.8)];
    let mut viewpoints = Vec::new();
    for (k, tolerance) in [0.5, 1.0, 2.0].into_iter().enumerate() {
        for (p, path) in [Path::Approach, Path::Pan, Path::FlyBy].into_iter().enumerate() {
            for (i, height) in [1_500.0, 8_000.0].into_iter().enumerate() {
                let site = sites[(k + p + i) % sites.len()].normalize();
                let viewpoint = Viewpoint { site, height, pitch: -0.6, tolerance, path };
                assert!(viewpoint.view(planet, 0.0, true).scale >= 1.0);
                viewpoints.push(viewpoint);
            }
        }
    }
    viewpoints
}

/// Motions over all paths in steps of STEP and of half of that.
fn motions(planet: &Planet, geomorphs: bool) -> Vec<[Motion; 2]> {
    let both =
        |viewpoint: &Viewpoint| [STEP, STEP / 2.0].map(|step| viewpoint.largest_motion(planet, 4.0 * STEP, step, geomorphs));
    viewpoints(planet).iter().map(both).collect()
}

#[test]
fn halving_the_way_between_frames_halves_the_motion() {
    let planet = planet(&FIELD, 16);
    let mut moving = 0;
    for ([whole, half], viewpoint) in motions(&planet, true).iter().zip(viewpoints(&planet)) {
        println!("{:?} at {} px, {} m: {whole:?} {half:?}", viewpoint.path, viewpoint.tolerance, viewpoint.height);
        // A vertex moves by at most the tolerance during its geomorph, so no motion is faster than that over the geomorph's length.
        assert!(whole.share_of_slide <= 1.0 && half.share_of_slide <= 1.0);
        assert!(half.pixels <= 0.6 * whole.pixels + SMALLEST, "{:?} at {} px", viewpoint.path, viewpoint.tolerance);
        moving += usize::from(whole.pixels > 5.0 * SMALLEST);
    }
    assert!(moving >= 9, "{moving} paths prove little");
}

#[test]
fn without_geomorphs_motions_do_not_shrink() {
    let planet = planet(&FIELD, 16);
    let motions = motions(&planet, false);
    let largest = |k: usize| motions.iter().map(|pair| pair[k].pixels).fold(0.0, f64::max);
    let (whole, half) = (largest(0), largest(1));
    assert!(whole > 0.1 && half >= 0.9 * whole, "{whole} px, {half} px at half the step");
}

/// Views to either side of every change of the cut along an approach.
fn changes_of_the_cut(planet: &Planet, viewpoint: &Viewpoint) -> Vec<[View; 2]> {
    let leaves = |way: f64| cut(&planet.tree, &viewpoint.view(planet, way, true), &|_| true).leaves;
    let mut found = Vec::new();
    for k in 0..40 {
        // The height falls by equal factors, to a hundredth in all.
        let [mut low, mut high] = [k, k + 1].map(|k| 1.0 - 0.01f64.powf(f64::from(k) / 40.0));
        if leaves(low) == leaves(high) {
            continue;
        }
        let before = leaves(low);
        for _ in 0..24 {
            let middle = (low + high) / 2.0;
            if leaves(middle) == before {
                low = middle;
            } else {
                high = middle;
            }
        }
        found.push([low, high].map(|way| viewpoint.view(planet, way, true)));
    }
    found
}

#[test]
fn where_the_cut_changes_the_surface_moves_by_two_tolerances_at_most() {
    let planet = planet(&FIELD, 16);
    let (mut worst, mut changes, mut unchecked) = (0.0f64, 0, 0.0f64);
    let sites = [DVec3::ONE, DVec3::new(1.0, 0.95, 0.98), DVec3::new(1.0, 0.97, 1.0), DVec3::new(0.98, 1.0, 0.96)];
    for (site, tolerance) in sites.into_iter().zip([0.5, 1.0, 2.0, 1.0]) {
        let site = site.normalize();
        let viewpoint = Viewpoint { site, height: 600_000.0, pitch: -1.5, tolerance, path: Path::Approach };
        for [before, after] in changes_of_the_cut(&planet, &viewpoint) {
            let [a, b] = [before, after].map(|view| Frame::new(&planet, view, &|_| true));
            let moved = motion(&a, &b, STEP).pixels;
            worst = worst.max(moved / tolerance);
            changes += usize::from(moved > SMALLEST);
            let coarse = Frame::new(&planet, after, &|id| id.level == 0);
            unchecked = unchecked.max(motion(&a, &coarse, STEP).pixels / tolerance);
        }
    }
    println!("{changes} changes, {worst} tolerances; to the whole faces {unchecked}");
    assert!(changes >= 20 && (0.1..=2.0).contains(&worst), "{changes} changes, {worst} tolerances");
    assert!(unchecked > 2.0, "a cut that is too coarse passes: {unchecked} tolerances");
}
