//! The judge: how far a drawn surface lies from the finest one at the probes of a view, and how many triangles it took.
//!
//! Each face of the cube has a gnomonic plane, in which a triangle seen from the planet's centre is a triangle again and the
//! reciprocal of its depth is affine. A probe is a point of that plane with the finest surface's radius there; the radius of the
//! triangle above it is one affine evaluation in f64. Nothing here knows which method made the triangles.

use super::probes::{ProbeTree, Probes};
use glam::DVec3;
use terrane_planet::draw::view::View;
use terrane_planet::globe::sphere::Face;

/// Vertices are rounded to the lattice, so neighbouring triangles of different levels may leave a gap of this many units between
/// them, in which either one counts as hit.
const GAP: f64 = 4.0;

/// Rounding of a point's turn about an edge, relative to its distance from the corners.
const TURN_ROUNDING: f64 = 1e-15;

/// What was drawn in one view, triangle by triangle.
pub(crate) struct Sheet<'a> {
    view: &'a View,
    probes: &'a Probes,
    /// By face: the largest error where a triangle covers a probe.
    covered: Vec<Vec<f32>>,
    /// By face: the least error of the triangles that a probe lies beside by less than the gap.
    beside: Vec<Vec<f32>>,
    gap: f64,
    /// Triangles handed in.
    pub(crate) submitted: usize,
    /// Those that are in the frustum and face the camera.
    pub(crate) in_view: usize,
    numbers: Vec<u32>,
    corners: Vec<Corner>,
}

/// A corner in the gnomonic plane, and relative to the eye.
#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 2],
    /// 1 / distance along the face's normal.
    depth: f64,
    relative: DVec3,
}

/// What a view showed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reading {
    /// Triangles handed in.
    pub(crate) submitted: usize,
    /// Those that are in the frustum and face the camera.
    pub(crate) in_view: usize,
    /// Largest error at any probe, in pixels.
    pub(crate) max: f64,
    /// Errors at random pixels.
    pub(crate) at_pixels: Vec<f32>,
    /// Where it was read: lattice units from the planet's centre.
    pub(crate) worst: DVec3,
    /// Probes under no triangle.
    pub(crate) missed: usize,
}

impl<'a> Sheet<'a> {
    /// An empty one.
    pub(crate) fn new(view: &'a View, probes: &'a Probes, radius: f64) -> Sheet<'a> {
        let unknown = |value: f32| probes.faces.iter().map(|tree| vec![value; tree.probes.len()]).collect();
        Sheet {
            view,
            probes,
            covered: unknown(-1.0),
            beside: unknown(f32::INFINITY),
            gap: GAP / radius,
            submitted: 0,
            in_view: 0,
            numbers: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Adds triangles over a face; `position` gives the position in lattice units of each of `count` vertices.
    pub(crate) fn add(&mut self, face: Face, count: usize, position: impl Fn(u32) -> DVec3, triangles: &[[u32; 3]]) {
        self.numbers.clear();
        self.numbers.resize(count, u32::MAX);
        self.corners.clear();
        for triangle in triangles {
            let corners = triangle.map(|v| {
                let number = &mut self.numbers[v as usize];
                if *number == u32::MAX {
                    *number = self.corners.len() as u32;
                    self.corners.push(Corner::new(face, position(v), self.view.eye));
                }
                self.corners[*number as usize]
            });
            self.add_triangle(face, &corners);
        }
    }

    fn add_triangle(&mut self, face: Face, corners: &[Corner; 3]) {
        self.submitted += 1;
        self.in_view += usize::from(is_seen(self.view, &corners.map(|c| c.relative)));
        let tree = &self.probes.faces[usize::from(face.index())];
        let (covering, beside) = (&mut self.covered[usize::from(face.index())], &mut self.beside[usize::from(face.index())]);
        measure(tree, corners, self.gap, covering, beside);
    }

    /// What all triangles together showed.
    pub(crate) fn finish(self) -> Reading {
        let mut reading = Reading { submitted: self.submitted, in_view: self.in_view, ..Reading::default() };
        let faces = Face::ALL.iter().zip(&self.probes.faces);
        for (((&face, tree), covered), beside) in faces.zip(&self.covered).zip(&self.beside) {
            for ((probe, &covered), &beside) in tree.probes.iter().zip(covered).zip(beside) {
                let error = if covered >= 0.0 { covered } else { beside };
                if error.is_infinite() {
                    reading.missed += 1;
                    continue;
                }
                if f64::from(error) > reading.max {
                    (reading.max, reading.worst) = (f64::from(error), probe.position(face));
                }
                if probe.pixel {
                    reading.at_pixels.push(error);
                }
            }
        }
        reading
    }
}

impl Corner {
    fn new(face: Face, position: DVec3, eye: DVec3) -> Corner {
        let (u, v) = face.grid_axes();
        let along = position[face.normal_axis()].abs();
        Corner { at: [position[u] / along, position[v] / along], depth: 1.0 / along, relative: position - eye }
    }
}

/// The rule of `emit`: not wholly beyond one plane of the frustum, and the eye on the outer side.
fn is_seen(view: &View, [a, b, c]: &[DVec3; 3]) -> bool {
    let beyond = |plane: &DVec3| plane.dot(*a) > 0.0 && plane.dot(*b) > 0.0 && plane.dot(*c) > 0.0;
    (*b - *a).cross(*c - *a).dot(*a) < 0.0 && !view.planes.iter().any(beyond)
}

fn measure(tree: &ProbeTree, corners: &[Corner; 3], gap: f64, covered: &mut [f32], beside: &mut [f32]) {
    let [a, b, c] = corners.map(|corner| corner.at);
    let low = [0, 1].map(|k: usize| a[k].min(b[k]).min(c[k]) - gap);
    let high = [0, 1].map(|k: usize| a[k].max(b[k]).max(c[k]) + gap);
    tree.visit(low, high, |k| {
        let probe = &tree.probes[k];
        let [da, db, dc] = [a, b, c].map(|p| [p[0] - probe.at[0], p[1] - probe.at[1]]);
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let turns = [cross(db, dc), cross(dc, da), cross(da, db)];
        let turn: f64 = turns.iter().sum();
        if turn == 0.0 {
            return;
        }
        let turns = turns.map(|t| t * turn.signum());
        let reach = [da, db, dc].iter().flatten().fold(0.0f64, |most, d| most.max(d.abs()));
        let least = turns[0].min(turns[1]).min(turns[2]);
        let inside = least >= -TURN_ROUNDING * reach;
        let near = |turn: f64, p: [f64; 2], q: [f64; 2]| {
            turn >= 0.0 || turn * turn <= gap * gap * ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2))
        };
        let beside_all = || near(turns[0], b, c) && near(turns[1], c, a) && near(turns[2], a, b);
        if !(inside || beside_all()) {
            return;
        }
        let weights = turns.map(|t| t.max(0.0));
        let depth = weights.iter().zip(corners).map(|(w, c)| w * c.depth).sum::<f64>() / weights.iter().sum::<f64>();
        let error = ((probe.slant / depth - probe.radius).abs() * probe.pixels_a_unit) as f32;
        if inside {
            covered[k] = covered[k].max(error);
        } else {
            beside[k] = beside[k].min(error);
        }
    });
}
