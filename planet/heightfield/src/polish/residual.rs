//! What single triangles miss: their largest residual and where it is, and the costs that flips and removals compare.

use super::mesh::{aspect, doubled_area};
use crate::raster::for_each_owned;
use crate::Heightfield;
use glam::DVec3;

/// Aspect (see [`aspect`]) from which a triangle counts as a sliver.
pub(super) const ASPECT_LIMIT: f64 = 20.0;

/// What a triangle of twice the [`ASPECT_LIMIT`] costs, where a sample with the largest residual costs 1: changes that lower
/// residuals well below the largest do not make slivers, those that lower the largest may. A tenth of this leaves twice as many
/// slivers and wins nothing.
const SLIVER_COST: f64 = 0.2;

/// Calls `visit(sample, residual)` for every sample that a triangle owns; residuals are surface less field.
pub(super) fn for_each_residual(triangle: [DVec3; 3], field: &Heightfield, mut visit: impl FnMut(usize, f64)) {
    let plane = Plane::new(triangle);
    for_each_owned(triangle, field, |y, first, row| {
        let west = plane.at(first, y);
        for (k, sample) in row.enumerate() {
            visit(sample, west + k as f64 * plane.east - f64::from(field.heights()[sample]));
        }
    });
}

/// The plane of a triangle.
pub(super) struct Plane {
    corner: DVec3,
    /// Rise per cell to the east and north.
    pub(super) east: f64,
    north: f64,
}

impl Plane {
    pub(super) fn new([a, b, c]: [DVec3; 3]) -> Plane {
        let area = doubled_area([a, b, c]);
        let (p, q) = (b - a, c - a);
        Plane { corner: a, east: (p.z * q.y - q.z * p.y) / area, north: (q.z * p.x - p.z * q.x) / area }
    }

    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        self.corner.z + (x - self.corner.x) * self.east + (y - self.corner.y) * self.north
    }
}

/// Largest residual of a triangle.
pub(super) fn peak(triangle: [DVec3; 3], field: &Heightfield) -> f64 {
    let mut peak = 0.0f64;
    for_each_residual(triangle, field, |_, residual| peak = peak.max(residual.abs()));
    peak
}

/// Cost of a triangle: the sum of the twelfth powers of its residuals in units of `top`, and something for slivers.
pub(super) fn cost(triangle: [DVec3; 3], field: &Heightfield, top: f64) -> f64 {
    let scale = 1.0 / (top * top);
    let mut sum = 0.0;
    for_each_residual(triangle, field, |_, residual| {
        let square = residual * residual * scale;
        let cube = square * square * square;
        sum += cube * cube;
    });
    sum + SLIVER_COST * (aspect(triangle) / ASPECT_LIMIT - 1.0).max(0.0)
}

/// Whether a triangle is no sliver.
pub(super) fn aspect_is_kept(triangle: [DVec3; 3]) -> bool {
    aspect(triangle) <= ASPECT_LIMIT
}
