//! Moves vertices up and down so that the largest residual falls: damped Newton steps on the sum of the p-th powers of residuals,
//! with p
//! rising from call to call. In: a triangulation and the peaks of its faces. Out: both, with the lowest top that was seen.
//!
//! Only vertices of hot faces move. A sweep takes sums over the samples of each face (on all cores), then adds them up at the
//! vertices in the order of faces, so that the result does not depend on how many cores there are.

use super::mesh::{doubled_area, Triangulation};
use super::residual::Plane;
use super::{largest, HOT};
use crate::raster::for_each_owned;
use crate::Heightfield;
use glam::DVec3;
use rayon::prelude::*;

/// Some sweeps with the same p = 2^(`doublings` + 2).
#[derive(Clone, Copy)]
pub(super) struct Sweeps {
    pub(super) doublings: u32,
    pub(super) count: usize,
}

/// How much longer than a step of the diagonal Newton method, which is timid, a step is.
const STEP: f64 = 1.5;

/// Share of the last step that is made once more.
const MOMENTUM: f64 = 0.5;

/// Faces that a thread takes at a time.
const CHUNK: usize = 512;

/// Slope and curvature of the sum over one face, at its three corners, and its largest residual.
#[derive(Clone, Copy, Default)]
struct Sums {
    slope: [f64; 3],
    curvature: [f64; 3],
    peak: f64,
}

pub(super) fn fit(mesh: &mut Triangulation, field: &Heightfield, peaks: &mut [f64], sweeps: Sweeps) {
    let mut active = Active::new(mesh, peaks);
    for _ in 0..sweeps.count {
        active.measure(mesh, field, sweeps.doublings);
        if active.top == 0.0 {
            return;
        }
        active.remember_best(mesh, peaks);
        active.step(mesh, sweeps.doublings);
    }
    active.measure(mesh, field, sweeps.doublings);
    active.remember_best(mesh, peaks);
    active.restore_best(mesh);
}

/// The vertices that move, and the faces that touch them.
struct Active {
    vertices: Vec<u32>,
    faces: Vec<u32>,
    sums: Vec<Sums>,
    /// Of every vertex of the mesh: slope, curvature and last step.
    at_vertex: Vec<[f64; 3]>,
    top: f64,
    best_top: f64,
    best: Vec<f64>,
}

impl Active {
    fn new(mesh: &Triangulation, peaks: &[f64]) -> Active {
        let top = largest(peaks);
        let alive = || (0..mesh.capacity() as u32).filter(|&t| mesh.is_alive(t));
        let mut moves = vec![false; mesh.positions.len()];
        for t in alive().filter(|&t| peaks[t as usize] > HOT * top) {
            mesh.corners(t).into_iter().for_each(|v| moves[v as usize] = true);
        }
        let faces: Vec<u32> = alive().filter(|&t| mesh.corners(t).into_iter().any(|v| moves[v as usize])).collect();
        let vertices = (0..moves.len() as u32).filter(|&v| moves[v as usize]).collect();
        let sums = vec![Sums::default(); faces.len()];
        let at_vertex = vec![[0.0; 3]; moves.len()];
        Active { vertices, faces, sums, at_vertex, top, best_top: f64::INFINITY, best: Vec::new() }
    }

    fn measure(&mut self, mesh: &Triangulation, field: &Heightfield, doublings: u32) {
        let scale = 1.0 / self.top;
        let chunks = self.faces.par_chunks(CHUNK).zip(self.sums.par_chunks_mut(CHUNK));
        chunks.for_each(|(faces, sums)| {
            for (sum, &face) in sums.iter_mut().zip(faces) {
                *sum = sum_face(mesh.triangle(face), field, scale, doublings);
            }
        });
        self.top = self.sums.iter().map(|sum| sum.peak).fold(0.0, f64::max);
    }

    fn remember_best(&mut self, mesh: &Triangulation, peaks: &mut [f64]) {
        if self.top < self.best_top {
            self.best_top = self.top;
            self.best.clear();
            self.best.extend(self.vertices.iter().map(|&v| mesh.positions[v as usize].z));
            self.faces.iter().zip(&self.sums).for_each(|(&face, sum)| peaks[face as usize] = sum.peak);
        }
    }

    fn restore_best(&self, mesh: &mut Triangulation) {
        self.vertices.iter().zip(&self.best).for_each(|(&v, &z)| mesh.positions[v as usize].z = z);
    }

    fn step(&mut self, mesh: &mut Triangulation, doublings: u32) {
        for (&face, sum) in self.faces.iter().zip(&self.sums) {
            for (k, v) in mesh.corners(face).into_iter().enumerate() {
                let [slope, curvature, _] = &mut self.at_vertex[v as usize];
                *slope += sum.slope[k];
                *curvature += sum.curvature[k];
            }
        }
        let order = f64::from((4u32 << doublings) - 1);
        for &v in &self.vertices {
            let [slope, curvature, last] = self.at_vertex[v as usize];
            let step = if curvature > 0.0 { -STEP * slope / (order * curvature) } else { 0.0 };
            let step = step + MOMENTUM * last;
            mesh.positions[v as usize].z += step;
            self.at_vertex[v as usize][2] = step;
        }
        self.at_vertex.iter_mut().for_each(|[slope, curvature, _]| (*slope, *curvature) = (0.0, 0.0));
    }
}

/// Sums over the samples of a triangle: of weights and of weighted residuals, each times 1, x and y, which gives those times the
/// barycentric coordinates.
fn sum_face(triangle: [DVec3; 3], field: &Heightfield, scale: f64, doublings: u32) -> Sums {
    let [a, b, c] = triangle;
    let plane = Plane::new(triangle);
    let mut peak = 0.0f64;
    let (mut slope, mut curvature) = ([0.0; 3], [0.0; 3]);
    for_each_owned(triangle, field, |y, first, row| {
        let west = plane.at(first, y);
        let (mut s, mut sx, mut w, mut wx) = (0.0, 0.0, 0.0, 0.0);
        for (k, &height) in field.heights()[row].iter().enumerate() {
            let k = k as f64;
            let residual = west + k * plane.east - f64::from(height);
            peak = peak.max(residual.abs());
            let weight = weight(residual * scale, doublings);
            let weighted = weight * residual;
            s += weighted;
            sx += weighted * k;
            w += weight;
            wx += weight * k;
        }
        let (x, y) = (first - a.x, y - a.y);
        slope = [slope[0] + s, slope[1] + s * x + sx, slope[2] + s * y];
        curvature = [curvature[0] + w, curvature[1] + w * x + wx, curvature[2] + w * y];
    });
    let area = doubled_area(triangle);
    let shares = |[all, x, y]: [f64; 3]| {
        let at_b = (x * (c.y - a.y) - y * (c.x - a.x)) / area;
        let at_c = (y * (b.x - a.x) - x * (b.y - a.y)) / area;
        [all - at_b - at_c, at_b, at_c]
    };
    Sums { slope: shares(slope), curvature: shares(curvature), peak }
}

/// The (p - 2)-th power of a residual, and a little, so that vertices with small residuals have a curvature.
fn weight(residual: f64, doublings: u32) -> f64 {
    let square = residual * residual;
    let mut weight = square;
    for _ in 0..doublings {
        weight = weight * weight * square;
    }
    weight + 1e-12
}
