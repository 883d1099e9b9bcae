//! Rays against the known ground, which is solid: a ray meets it where it first comes below the surface.
//!
//! Seen from the planet's centre a ray is straight and patches are convex: it passes through one leaf after the other and never
//! comes back to one. In each leaf obvhs finds the triangles beside it. Where leaves of different levels meet there may be a step; a ray
//! that would slip below the higher one meets that step.

use super::known_ground::KnownGround;
use super::patch_grid::PatchGrid;
use super::rays::Ray;
use crate::globe::patch::{PatchId, MAX_LEVEL};
use crate::globe::sphere::{warp_component, Face};
use glam::DVec3;

/// Lattice units by which rounded corners may lie aside of where they should: what is no deeper below the ground is not below.
const SURFACE: f64 = 2.0;

/// Lattice units from the side that a ray leaves a leaf by to a point that surely is in the next one.
const SIDESTEP: f64 = 1e-3;

/// Lattice units within which a ray that crosses two sides passes through their corner.
const CORNER: f64 = 1.0;

/// Where a ray meets the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundHit {
    /// Metres from the ray's origin; 0 if that lies in the ground.
    pub distance: f64,
    /// The position in planet-fixed metres.
    pub position: DVec3,
    /// Metres above the datum.
    pub height: f64,
    /// The patch that was met.
    pub patch: PatchId,
    /// Mean distance of its samples in metres.
    pub spacing: f64,
}

impl KnownGround {
    /// Where a ray first meets the ground. `origin` in planet-fixed metres, `direction` of any length but zero. `None` if it meets
    /// nothing that is known, or if it is no ray.
    pub fn raycast(&self, origin: DVec3, direction: DVec3) -> Option<GroundHit> {
        let ray = Ray { origin: origin / self.lattice.unit, direction: direction.try_normalize()? };
        let (enter, leave) = self.shell(&ray).filter(|_| !self.is_empty())?;
        // Distances from nearby, so that they are exact however far away the ray begins.
        let near = Ray { origin: ray.at(enter), ..ray };
        let (distance, patch) = self.walk(&near, leave - enter)?;
        let hit = near.at(distance);
        Some(GroundHit {
            distance: (enter + distance) * self.lattice.unit,
            position: hit * self.lattice.unit,
            height: (hit.length() - self.lattice.radius) * self.lattice.unit,
            patch,
            spacing: self.spacing(patch.level),
        })
    }

    /// Between which distances the ray is below the highest ground.
    fn shell(&self, ray: &Ray) -> Option<(f64, f64)> {
        let radius = self.lattice.radius + f64::from(self.highest) + SURFACE;
        let middle = -ray.origin.dot(ray.direction);
        let aside = ray.at(middle).length();
        let half = ((radius - aside) * (radius + aside)).sqrt();
        // Not a number where the ray passes by, or where it is no ray.
        (middle + half >= 0.0).then_some(((middle - half).max(0.0), middle + half))
    }

    /// Distance to the ground within `reach`, and the patch.
    fn walk(&self, ray: &Ray, reach: f64) -> Option<(f64, PatchId)> {
        let (mut at, mut aside) = (0.0, DVec3::ZERO);
        for _ in 0..self.len() + Face::ALL.len() {
            let id = self.leaf(ray.at(at) + aside, MAX_LEVEL);
            let (exit, outward) = exit(ray, id);
            let exit = exit.clamp(at, reach);
            if let Some(distance) = self.grid(id).and_then(|grid| self.meet(ray, grid, at, exit)) {
                return Some((distance, id));
            }
            if exit >= reach {
                return None;
            }
            // Through a corner of leaves it goes by two sides, and must not come back over the first.
            let before = if exit - at < CORNER { aside } else { DVec3::ZERO };
            (at, aside) = (exit, before + outward * SIDESTEP);
        }
        None
    }

    /// Distance to the ground of a leaf that the ray passes between two distances.
    fn meet(&self, ray: &Ray, grid: &PatchGrid, enter: f64, exit: f64) -> Option<f64> {
        let lowest = ray.at((-ray.origin.dot(ray.direction)).clamp(enter, exit)).length();
        if lowest > self.lattice.radius + f64::from(grid.highest) + SURFACE {
            return None;
        }
        let first = ray.at(enter);
        let ground = grid.radius(first.try_normalize().unwrap_or(grid.id.centre()));
        if ground.is_some_and(|radius| first.length() < radius - SURFACE) {
            return Some(enter);
        }
        grid.nearest(ray, &self.triangles)
    }
}

/// The distance at which a ray from inside a patch leaves it, and the outward unit normal of the side that it leaves by; infinite if it
/// stays. Sides lie in planes through the planet's centre.
fn exit(ray: &Ray, id: PatchId) -> (f64, DVec3) {
    let (u, v) = id.face.grid_axes();
    let up = id.face.normal();
    let (low, high) = (id.point(0, 0, 1), id.point(1, 1, 1));
    let side = |axis: usize, corner: glam::IVec3, sign: f64| (DVec3::AXES[axis] - up * warp_component(corner[axis])) * sign;
    let sides = [side(u, low, -1.0), side(u, high, 1.0), side(v, low, -1.0), side(v, high, 1.0)];
    let leaving = sides.into_iter().filter(|side| side.dot(ray.direction) > 0.0);
    let exits = leaving.map(|side| (-side.dot(ray.origin) / side.dot(ray.direction), side.normalize()));
    exits.fold((f64::INFINITY, DVec3::ZERO), |first, next| if next.0 < first.0 { next } else { first })
}
