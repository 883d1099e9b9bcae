//! The boxes that a ray passes, nearest first: obvhs's BVH behind exact positions.
//!
//! In: boxes on the lattice, rays in f64. obvhs works in f32, which holds no lattice position: boxes and rays are taken relative
//! to the middle of all boxes, rays from where they enter, and boxes are widened by more than that rounds. So no box is
//! missed, and whoever is asked what lies in a box can answer exactly.

use super::Ray;
use crate::globe::lattice::LatticeBox;
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::Bvh2;
use obvhs::ray::RayHit;
use obvhs::BvhBuildParams;
use std::time::Duration;

/// By how much boxes are widened, relative to the size of them all together. Rounding origin, direction and box to f32 moves
/// neither by more than a third of this.
const WIDENING: f64 = 1.0 / (1u32 << 20) as f64;

/// Boxes by position.
pub(crate) struct BoxTree {
    low: DVec3,
    high: DVec3,
    margin: f64,
    bvh: Bvh2,
}

impl BoxTree {
    pub(crate) fn new(boxes: &[LatticeBox]) -> BoxTree {
        let all = boxes.iter().fold(LatticeBox::EMPTY, |all, &one| all.union(one));
        let (low, high) = (all.low.as_dvec3(), all.high.as_dvec3());
        let margin = (high - low).max_element().max(1.0) * WIDENING;
        let (low, high) = (low - margin, high + margin);
        let middle = (low + high) / 2.0;
        let widened = |b: &LatticeBox| {
            let (low, high) = (b.low.as_dvec3() - middle - margin, b.high.as_dvec3() - middle + margin);
            Aabb::new(low.as_vec3a(), high.as_vec3a())
        };
        let boxes: Vec<Aabb> = boxes.iter().map(widened).collect();
        let bvh = build_bvh2(&boxes, BvhBuildParams::very_fast_build(), &mut Duration::default());
        BoxTree { low, high, margin, bvh }
    }

    /// The nearest of the distances that `hit` gives for the boxes on the ray's way.
    pub(crate) fn nearest(&self, ray: &Ray, mut hit: impl FnMut(usize) -> Option<f64>) -> Option<f64> {
        let (entry, exit) = self.span(ray)?;
        let origin = ray.origin + ray.direction * entry - (self.low + self.high) / 2.0;
        let reach = (exit - entry) + self.margin;
        let local = obvhs::ray::Ray::new(origin.as_vec3a(), ray.direction.as_vec3a(), 0.0, reach as f32);
        let mut nearest: Option<f64> = None;
        self.bvh.ray_traverse(local, &mut RayHit::none(), |_, k| {
            let Some(distance) = hit(self.bvh.primitive_indices[k] as usize) else { return f32::INFINITY };
            nearest = Some(nearest.map_or(distance, |found| found.min(distance)));
            (distance - entry + self.margin) as f32
        });
        nearest
    }

    /// Between which distances the ray is inside the box around everything.
    fn span(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (mut entry, mut exit) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (origin, slope) = (ray.origin[axis], ray.direction[axis]);
            if slope == 0.0 {
                if origin < self.low[axis] || origin > self.high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.low[axis] - origin) / slope, (self.high[axis] - origin) / slope);
            entry = entry.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        (entry <= exit).then_some((entry, exit))
    }
}
