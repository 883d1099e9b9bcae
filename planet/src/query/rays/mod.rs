//! Rays against the ground: triangles with exact lattice corners, met in f64 a planet's radius away from the centre.
//!
//! Shared by whoever asks where the ground is and by those who judge what is drawn ([`crate::verify`]).

pub(crate) mod box_tree;
pub mod patch_surface;

pub use patch_surface::PatchSurface;

use glam::DVec3;

/// By how much rounding may move a ray aside, relative to the distance from its origin.
const RAY_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A half line; the direction has length 1.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it begins, in lattice units.
    pub origin: DVec3,
    /// Where it goes.
    pub direction: DVec3,
}

impl Ray {
    /// From the planet's centre through a point.
    pub fn radial(through: DVec3) -> Ray {
        Ray { origin: DVec3::ZERO, direction: through.normalize() }
    }

    /// The point at a distance.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }

    /// Distance to a triangle, or to its plane where the ray passes it by at most half of `margin` lattice units.
    ///
    /// The ray turns the same way about the three edges of a triangle that it passes. Through a vertex it turns about several
    /// edges by less than f64 can tell: what may be a hit is one, so that no ray slips between triangles. Corners are taken relative
    /// to a point of the ray beside them: relative to a distant origin a ray could not be told from one several lattice units aside.
    pub fn distance_to(&self, triangle: [DVec3; 3], margin: f64) -> Option<f64> {
        let far = triangle.map(|corner| corner - self.origin);
        let along = far.map(|corner| self.direction.dot(corner));
        let [a, b, c] = far.map(|corner| corner - self.direction * along[0]);
        let [u, v, w] = [(b, c), (c, a), (a, b)].map(|(p, q)| self.direction.dot(p.cross(q)));
        let slack = (RAY_ROUNDING * far[0].length() + margin) * a.length().max(b.length()).max(c.length());
        if u.min(v).min(w) < -slack && u.max(v).max(w) > slack {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let distance = along[0] + normal.dot(a) / normal.dot(self.direction);
        // A triangle seen edge-on has no one distance, but none beyond its corners'.
        let [nearest, farthest] = [along.into_iter().fold(f64::MAX, f64::min), along.into_iter().fold(f64::MIN, f64::max)];
        Some(distance.clamp(nearest, farthest)).filter(|distance| *distance >= 0.0)
    }
}
