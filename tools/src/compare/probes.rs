//! Where the screen error of a view is measured: the same points for every method.
//!
//! Where the rays of random pixels meet our own surface, for percentiles of what is seen; and samples of the patches that a four times finer tolerance would draw, of
//! each block the one where the ground bends most, because that is where approximations are farthest off. Of both, those in the
//! frustum that the planet's horizon does not hide.

use super::ours::Ours;
use super::setting::{CutRule, PatchCache, Setting};
use glam::{DVec3, IVec3};
use terrane_planet::globe::sphere::Face;
use terrane_planet::store::StoreError;

use terrane_planet::globe::random::Random;

use terrane_planet::draw::view::{Camera, View};
use terrane_planet::query::rays::patch_surface::PatchSurface;
use terrane_planet::query::rays::Ray;
use terrane_planet::verify::is_in_view;

/// Share of the target tolerance with which the patches are chosen whose samples are probed.
const FINER: f64 = 0.25;

/// Grid cells over which bending is looked for.
const STRIDES: [i32; 4] = [1, 2, 4, 8];

/// Probes in a leaf of the tree.
const LEAF: usize = 8;

/// How much to measure in each view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Random pixels.
    pub(crate) pixels: usize,
    /// Cells along a side of the blocks of which one sample is probed.
    pub(crate) block: usize,
}

/// One point in the gnomonic plane of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    /// Position in the plane.
    pub(crate) at: [f64; 2],
    /// Distance from the planet's centre over distance along the face's normal.
    pub(crate) slant: f64,
    /// Distance of the finest surface from the planet's centre in lattice units.
    pub(crate) radius: f64,
    /// Pixels that one lattice unit subtends there.
    pub(crate) pixels_a_unit: f64,
    /// Whether it is a random pixel.
    pub(crate) pixel: bool,
}

impl Probe {
    /// Its position in lattice units from the planet's centre.
    pub(crate) fn position(&self, face: Face) -> DVec3 {
        let (u, v) = face.grid_axes();
        let mut direction = DVec3::ZERO;
        (direction[u], direction[v]) = (self.at[0], self.at[1]);
        direction[face.normal_axis()] = f64::from(face.sign());
        direction.normalize() * self.radius
    }
}

/// The probes of one view.
pub(crate) struct Probes {
    /// By face.
    pub(crate) faces: Vec<ProbeTree>,
}

/// Chooses the probes of views that are meant to be drawn within `target` pixels.
pub(crate) struct Chooser<'a> {
    setting: &'a Setting,
    target: f64,
    effort: Effort,
    /// The samples of each patch that are probed.
    bends: PatchCache<Vec<u16>>,
    ours: Ours,
}

impl<'a> Chooser<'a> {
    /// A chooser that has not read any patch yet.
    pub(crate) fn new(setting: &'a Setting, target: f64, effort: Effort) -> Chooser<'a> {
        Chooser { setting, target, effort, bends: PatchCache::new(), ours: Ours::new() }
    }

    /// Directions from the planet's centre in which rays through random pixels meet our surface.
    fn pixels(&self, view: &View, seed: u64) -> Result<Vec<DVec3>, StoreError> {
        let mut surfaces = Vec::new();
        self.ours.patches(self.setting, view, |drawn| {
            surfaces.push(PatchSurface::of_drawn(drawn.vertices, drawn.drawn_positions, drawn.triangles));
        })?;
        let mut random = Random::new(seed);
        let (camera, (h, v)) = (&view.camera, view.camera.half_extents());
        let mut ray = || {
            let across = camera.right() * (h * random.range(-1.0, 1.0)) + camera.up * (v * random.range(-1.0, 1.0));
            Ray { origin: view.eye, direction: (camera.forward + across).normalize() }
        };
        let rays = (0..self.effort.pixels).map(|_| ray());
        let meet = |ray: Ray| {
            let nearest = surfaces.iter().filter_map(|surface| surface.nearest(&ray)).reduce(f64::min)?;
            Some((ray.origin + ray.direction * nearest).normalize())
        };
        Ok(rays.filter_map(meet).collect())
    }
}

impl Probes {
    /// Chooses the probes of a view that is meant to be drawn within `target` pixels.
    pub(crate) fn new(chooser: &Chooser, camera: &Camera, seed: u64) -> Result<Probes, StoreError> {
        let Chooser { setting, target, effort, .. } = chooser;
        let view = setting.view(camera, *target);
        let mut faces = vec![Vec::new(); Face::ALL.len()];
        let mut add = |point: DVec3, pixel: bool| {
            let face = Face::containing(point);
            faces[usize::from(face.index())].push(probe(&view, face, point, pixel));
        };
        for direction in chooser.pixels(&view, seed)? {
            if let Some(point) = setting.finest(direction)? {
                add(point, true);
            }
        }
        let finer = setting.view(camera, FINER * target);
        for leaf in setting.visible_leaves(&finer, CutRule::Detail) {
            let positions = setting.positions(leaf.id)?;
            let chosen = chooser.bends.get(leaf.id, || Ok(bending_samples(&positions, setting.tree.cells, effort.block)))?;
            let points = chosen.iter().map(|&v| positions[usize::from(v)].as_dvec3());
            points.filter(|&point| is_in_view(&view, &setting.tree, point)).for_each(|point| add(point, false));
        }
        Ok(Probes { faces: faces.into_iter().map(ProbeTree::new).collect() })
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.faces.iter().map(|tree| tree.probes.len()).sum()
    }
}

fn probe(view: &View, face: Face, point: DVec3, pixel: bool) -> Probe {
    let (u, v) = face.grid_axes();
    let along = point[face.normal_axis()].abs();
    let radius = point.length();
    Probe {
        at: [point[u] / along, point[v] / along],
        slant: radius / along,
        radius,
        pixels_a_unit: 1.0 / (view.eye.distance(point) * view.camera.pixel_angle()),
        pixel,
    }
}

/// Of each block of a grid the sample where the ground bends most.
fn bending_samples(positions: &[IVec3], cells: u32, block: usize) -> Vec<u16> {
    let side = cells as usize + 1;
    let heights: Vec<f64> = positions.iter().map(|p| p.as_dvec3().length()).collect();
    let mut best = vec![(-1.0f64, 0u16); side.div_ceil(block).pow(2)];
    for (k, _) in heights.iter().enumerate() {
        let held = &mut best[k / side / block * side.div_ceil(block) + k % side / block];
        let bend = bending(&heights, side as i32, k);
        if bend > held.0 {
            *held = (bend, k as u16);
        }
    }
    best.into_iter().map(|(_, k)| k).collect()
}

/// Largest distance of a sample from the middle of two others opposite each other.
fn bending(heights: &[f64], side: i32, k: usize) -> f64 {
    let (i, j) = (k as i32 % side, k as i32 / side);
    let at = |i: i32, j: i32| ((0..side).contains(&i) && (0..side).contains(&j)).then(|| heights[(j * side + i) as usize]);
    let mut most = 0.0f64;
    for (di, dj) in STRIDES.into_iter().flat_map(|s| [(s, 0), (0, s), (s, s), (s, -s)]) {
        if let (Some(a), Some(b)) = (at(i - di, j - dj), at(i + di, j + dj)) {
            most = most.max((heights[k] - 0.5 * (a + b)).abs());
        }
    }
    most
}

/// Probes of one face, by position: a k-d tree (Bentley 1975).
pub(crate) struct ProbeTree {
    /// The probes, those of a leaf side by side.
    pub(crate) probes: Vec<Probe>,
    nodes: Vec<Node>,
}

struct Node {
    low: [f64; 2],
    high: [f64; 2],
    first: u32,
    last: u32,
    /// Second child; the first one follows its parent. 0 for leaves.
    second: u32,
}

impl ProbeTree {
    fn new(mut probes: Vec<Probe>) -> ProbeTree {
        let mut nodes = Vec::with_capacity(probes.len() / LEAF * 4 + 1);
        if !probes.is_empty() {
            split(&mut probes, 0, &mut nodes);
        }
        ProbeTree { probes, nodes }
    }

    /// Calls back with every probe in the leaves that a rectangle touches.
    pub(crate) fn visit(&self, low: [f64; 2], high: [f64; 2], mut found: impl FnMut(usize)) {
        let apart = |node: &Node| (0..2).any(|k| node.low[k] > high[k] || node.high[k] < low[k]);
        let mut waiting = [0u32; 64];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let at = waiting[count];
            let node = &self.nodes[at as usize];
            if apart(node) {
                continue;
            }
            if node.second == 0 {
                (node.first..node.last).for_each(|k| found(k as usize));
                continue;
            }
            waiting[count] = at + 1;
            waiting[count + 1] = node.second;
            count += 2;
        }
    }
}

fn split(probes: &mut [Probe], first: u32, nodes: &mut Vec<Node>) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for probe in probes.iter() {
        for k in 0..2 {
            low[k] = low[k].min(probe.at[k]);
            high[k] = high[k].max(probe.at[k]);
        }
    }
    let own = nodes.len();
    nodes.push(Node { low, high, first, last: first + probes.len() as u32, second: 0 });
    if probes.len() <= LEAF {
        return;
    }
    let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
    let middle = probes.len() / 2;
    probes.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]));
    let (left, right) = probes.split_at_mut(middle);
    split(left, first, nodes);
    nodes[own].second = nodes.len() as u32;
    split(right, first + middle as u32, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_probe_in_a_rectangle_is_visited_once() {
        let mut random = Random::new(3);
        let mut at = || [random.range(-1.0, 1.0), random.range(-1.0, 1.0)];
        let of = |at| Probe { at, slant: 1.0, radius: 1.0, pixels_a_unit: 1.0, pixel: true };
        let tree = ProbeTree::new((0..1000).map(|_| of(at())).collect());
        for (low, high) in [([-0.3, 0.1], [0.2, 0.4]), ([-2.0, -2.0], [2.0, 2.0]), ([0.5, 0.5], [0.5, 0.5])] {
            let inside = |p: &Probe| (0..2).all(|k| (low[k]..=high[k]).contains(&p.at[k]));
            let mut seen = vec![0; 1000];
            tree.visit(low, high, |k| seen[k] += 1);
            assert!(seen.iter().zip(&tree.probes).all(|(&n, p)| n <= 1 && (n == 1 || !inside(p))));
        }
    }

    #[test]
    fn the_sample_that_sticks_out_of_its_block_is_probed() {
        let side = 17;
        let mut positions = vec![IVec3::new(1000, 0, 0); side * side];
        positions[5 * side + 6] = IVec3::new(1010, 0, 0);
        let chosen = bending_samples(&positions, 16, 8);
        assert!(chosen.contains(&(5 * 17 + 6)) && chosen.len() == 9, "{chosen:?}");
    }
}
