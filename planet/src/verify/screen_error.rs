//! The screen error, measured with rays: how far what is drawn lies from the finest resident surface, as the camera sees it.
//!
//! In: a view, the triangles drawn in it, the finest surface. Out: readings in pixels, those of triangles beside missing data
//! apart. The judge shares nothing with the builder but the file: it knows triangles and lattice positions only.
//!
//! Measured are the hits of camera rays through random pixels, every vertex of the drawn patches that sleeps or slides, and samples of
//! finer resident patches than the drawn ones; of both, those inside the frustum that the planet's ball does not hide
//! (hills hide nothing: stricter than what is seen). Through each point a ray from the planet's centre meets both surfaces;
//! their distance over that of the nearer one to the camera is the error, in radians and then in pixels of the
//! picture's middle; in views with the orientation term it is the angle between the two.

use super::error_readings::{ErrorReadings, Probe, Reading};
use super::finest::FinestSurface;
use crate::draw::cut::{is_visible, sides_beside, Leaf};
use crate::draw::layout::{DrawnVertex, PatchVertex};
use crate::draw::tree::{PatchTree, SeaSpace};
use crate::draw::view::View;
use crate::globe::lattice::LatticeBox;
use crate::globe::patch::PatchId;
use crate::globe::random::Random;
use crate::query::rays::box_tree::BoxTree;
use crate::query::rays::{PatchSurface, Ray};
use crate::reference::select::on_sides;
use crate::store::StoreError;
use glam::{DVec3, IVec3};
use rayon::prelude::*;

/// Camera rays a parallel task.
const PIXELS_A_TASK: usize = 512;

/// Samples taken of a finer patch.
const SAMPLES_A_PATCH: usize = 256;

/// How much to measure beyond the vertices that sleep or slide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Camera rays a view.
    pub pixels: usize,
    /// Samples of finer patches a view.
    pub finer_samples: usize,
    /// Seed of both.
    pub seed: u64,
}

/// One drawn patch: its vertices, how far they are on their ways, and the triangles drawn, without culling.
pub struct Drawn<'a> {
    /// The patch.
    pub leaf: Leaf,
    /// All vertices in wake order.
    pub vertices: &'a [PatchVertex],
    /// Where a prefix of them is drawn; the others sleep.
    pub drawn_positions: &'a [DrawnVertex],
    /// Triangles, as vertex indices.
    pub triangles: &'a [[u32; 3]],
}

/// What one view showed.
#[derive(Clone, Debug, Default)]
pub struct ScreenError {
    /// Readings that the tolerance is promised for.
    pub readings: ErrorReadings,
    /// Readings on triangles that end on a side beside a coarser patch whose children are missing: vertices that only the finer
    /// patch has must sleep there however near they are.
    pub at_data_rim: ErrorReadings,
    /// Points where one of the two surfaces was not met at all.
    pub missed: usize,
    /// Points where both lie so deep in the sea that no light comes back, seen from above it: nothing is promised of the ground there.
    pub in_the_dark: usize,
}

impl ScreenError {
    /// Adds what another part or view showed.
    pub fn merge(&mut self, other: &ScreenError) {
        self.readings.merge(&other.readings);
        self.at_data_rim.merge(&other.at_data_rim);
        self.in_the_dark += other.in_the_dark;
        self.missed += other.missed;
    }

    fn merged(mut self, other: ScreenError) -> ScreenError {
        self.merge(&other);
        self
    }
}

/// Measures a view. `is_missing` says which drawn patches would have to split, but have no children.
///
/// # Errors
/// If a patch of the finest surface cannot be read.
pub fn measure(
    view: &View,
    tree: &PatchTree,
    drawn: &[Drawn],
    finest: &FinestSurface,
    is_missing: &dyn Fn(PatchId) -> bool,
    effort: Effort,
) -> Result<ScreenError, StoreError> {
    let surfaces: Vec<_> = drawn.par_iter().map(|d| PatchSurface::of_drawn(d.vertices, d.drawn_positions, d.triangles)).collect();
    let boxes: Vec<LatticeBox> = surfaces.iter().map(|surface| surface.bounds).collect();
    let seen = |d: &Drawn| tree.get(d.leaf.id).is_none_or(|node| is_visible(tree, view, &node.space));
    let rim_sides = |d: &Drawn| sides_beside(&d.leaf, is_missing).into();
    let judge = Judge {
        view,
        tree,
        drawn,
        finest,
        boxes: BoxTree::new(&boxes),
        surfaces,
        visible: (0..drawn.len()).filter(|&k| seen(&drawn[k])).collect(),
        rim_sides: drawn.iter().map(rim_sides).collect(),
    };
    let sleepers = judge.visible.par_iter().map(|&k| Ok(judge.sleepers(k)));
    let tasks = effort.pixels.div_ceil(PIXELS_A_TASK);
    let pixels = (0..tasks).into_par_iter().map(|task| judge.pixels(Random::new(effort.seed ^ (task as u64) << 32)));
    let finer = judge.finer_patches(effort);
    let finer = finer.par_iter().map(|&(k, id, seed)| judge.finer_samples(k, id, Random::new(seed)));
    sleepers.chain(pixels).chain(finer).try_reduce(ScreenError::default, |a, b| Ok(a.merged(b)))
}

/// A drawn triangle on a ray.
#[derive(Clone, Copy)]
struct Hit {
    distance: f64,
    /// Number of its patch among those drawn.
    k: usize,
    /// `None` for a point on its border that its own triangles miss by a rounding.
    triangle: Option<[u32; 3]>,
}

struct Judge<'a, 'f> {
    view: &'a View,
    tree: &'a PatchTree,
    drawn: &'a [Drawn<'a>],
    finest: &'a FinestSurface<'f>,
    surfaces: Vec<PatchSurface<DVec3>>,
    boxes: BoxTree,
    /// Drawn patches of which something may be in view.
    visible: Vec<usize>,
    /// The sides of each drawn patch beside missing data.
    rim_sides: Vec<u32>,
}

impl Judge<'_, '_> {
    /// Every vertex of a drawn patch that is not in its own position: the finest surface has it, or one that deviates from it as
    /// it does there.
    fn sleepers(&self, k: usize) -> ScreenError {
        let Drawn { vertices, drawn_positions, .. } = &self.drawn[k];
        let away = |&v: &usize| drawn_positions.get(v).is_none_or(|drawn| drawn.weight > 0.0);
        let points = (0..vertices.len()).filter(away).map(|v| IVec3::from_array(vertices[v].position));
        self.samples(k, Probe::Sleeper, points)
    }

    /// Finer resident patches to take samples of, each with the drawn patch above it and a seed.
    fn finer_patches(&self, effort: Effort) -> Vec<(usize, PatchId, u64)> {
        let mut random = Random::new(!effort.seed);
        let coarse: Vec<usize> = self.visible.iter().copied().filter(|&k| !self.finest.ends_at(self.drawn[k].leaf.id)).collect();
        if coarse.is_empty() {
            return Vec::new();
        }
        let mut pick = || {
            let k = coarse[random.bits() as usize % coarse.len()];
            let mut id = self.drawn[k].leaf.id;
            while let Some(children) = id.children().filter(|_| !self.finest.ends_at(id)) {
                id = children[(random.bits() % 4) as usize];
            }
            (k, id, random.bits())
        };
        (0..effort.finer_samples.div_ceil(SAMPLES_A_PATCH)).map(|_| pick()).collect()
    }

    fn finer_samples(&self, k: usize, id: PatchId, mut random: Random) -> Result<ScreenError, StoreError> {
        let grid = self.finest.grid(id)?;
        let count = grid.positions.len();
        let points = (0..SAMPLES_A_PATCH).map(|_| grid.positions[random.bits() as usize % count]);
        Ok(self.samples(k, Probe::FinerSample, points))
    }

    /// Samples of the finest surface over a drawn patch.
    fn samples(&self, k: usize, probe: Probe, points: impl Iterator<Item = IVec3>) -> ScreenError {
        let mut error = ScreenError::default();
        for point in points.map(|p| p.as_dvec3()).filter(|&p| is_in_view(self.view, self.tree, p)) {
            let ray = Ray::radial(point);
            // A sample on a border may lie a rounding beyond it, over the neighbour.
            let own =
                self.surfaces[k].nearest_triangle(&ray).map(|(distance, triangle)| Hit { distance, k, triangle: Some(triangle) });
            let hit = own.or_else(|| self.hit(&ray).map(|beyond| Hit { k, triangle: None, ..beyond }));
            let drawn = hit.map(|hit| (hit.distance, hit));
            self.note(&mut error, probe, point, drawn, Some(point.length()));
        }
        error
    }

    fn pixels(&self, mut random: Random) -> Result<ScreenError, StoreError> {
        let mut error = ScreenError::default();
        let camera = &self.view.camera;
        let (h, v) = camera.half_extents();
        for _ in 0..PIXELS_A_TASK {
            let across = camera.right() * (h * random.range(-1.0, 1.0)) + camera.up * (v * random.range(-1.0, 1.0));
            let ray = Ray { origin: self.view.eye, direction: (camera.forward + across).normalize() };
            let Some(hit) = self.hit(&ray) else { continue };
            let point = ray.origin + ray.direction * hit.distance;
            if !is_in_view(self.view, self.tree, point) {
                continue;
            }
            self.note(&mut error, Probe::Pixel, point, Some((point.length(), hit)), self.finest.radius(point)?);
        }
        Ok(error)
    }

    /// Nearest drawn triangle.
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.boxes.nearest(ray, |k| {
            let (distance, triangle) = self.surfaces[k].nearest_triangle(ray)?;
            if nearest.is_none_or(|found| distance < found.distance) {
                nearest = Some(Hit { distance, k, triangle: Some(triangle) });
            }
            Some(distance)
        });
        nearest
    }

    /// Whether a drawn triangle ends on a side beside missing data, or slides from there.
    fn is_at_rim(&self, hit: &Hit) -> bool {
        let Drawn { vertices, drawn_positions, .. } = self.drawn[hit.k];
        let on_rim = |v: u32| on_sides(vertices[v as usize].grid(), self.tree.cells, self.rim_sides[hit.k]);
        let from_rim = |v: u32| drawn_positions[v as usize].weight > 0.0 && on_rim(vertices[v as usize].parent());
        self.rim_sides[hit.k] != 0 && hit.triangle.is_none_or(|t| t.iter().any(|&v| on_rim(v) || from_rim(v)))
    }

    fn note(&self, error: &mut ScreenError, probe: Probe, point: DVec3, drawn: Option<(f64, Hit)>, finest: Option<f64>) {
        let (Some((drawn, hit)), Some(finest)) = (drawn, finest) else {
            error.missed += 1;
            return;
        };
        let dark = |sea: SeaSpace| self.view.eye.length() > sea.surface && finest < sea.dark && drawn < sea.surface;
        if self.tree.sea.is_some_and(dark) {
            error.in_the_dark += 1;
            return;
        }
        let direction = point.normalize();
        let [a, b] = [drawn, finest].map(|radius| direction * radius - self.view.eye);
        let distance = a.length().min(b.length());
        let radians = match self.view.orientation {
            None => (drawn - finest).abs() / distance,
            Some(_) => a.cross(b - a).length() / (a.length() * b.length()),
        };
        let unit = self.tree.lattice.unit;
        let reading = Reading {
            pixels: radians / self.view.camera.pixel_angle(),
            patch: self.drawn[hit.k].leaf.id,
            probe,
            direction,
            drawn_m: drawn * unit,
            finest_m: finest * unit,
            distance_m: distance * unit,
        };
        let readings = if self.is_at_rim(&hit) { &mut error.at_data_rim } else { &mut error.readings };
        readings.add(reading);
    }
}

/// Whether a point lies in the frustum of a view, and the line to it does not pass through the ball inside the planet's ground or
/// sea (hills hide nothing).
pub fn is_in_view(view: &View, tree: &PatchTree, point: DVec3) -> bool {
    let line = point - view.eye;
    if view.planes.iter().any(|plane| plane.dot(line) > 0.0) {
        return false;
    }
    let lowest_at = -view.eye.dot(line) / line.length_squared();
    let passes_under = (0.0..1.0).contains(&lowest_at) && (view.eye + line * lowest_at).length() < tree.hidden_radius;
    !passes_under || view.eye.length() <= tree.hidden_radius
}
