//! The cube-sphere: exact integer points on the cube surface, and the direction each of them stands for.
//!
//! A [`CubePoint`] is an integer triple with at least one component at ±[`ONE`]. Faces that share an edge or a corner share
//! these triples, and [`direction`] treats x, y and z alike, so shared points have bit-identical directions by construction.
//! The warp evens out cell sizes (after the tangent warp of Lambers and Kolb 2012, here a polynomial so that only exactly
//! rounded operations are used).

use glam::{DVec3, IVec3};

/// A point on (or, for the rows beyond a face, beside) the cube surface, in units of 1/[`ONE`] of half a cube edge.
pub type CubePoint = IVec3;

/// Half the cube's edge: the largest component of a cube point on the surface.
pub const ONE: i32 = 1 << 30;

/// Polynomial warp coefficients; dyadic and summing to exactly one, so that `warp(±1) == ±1`.
const WARP: [f64; 3] = [101.0 / 128.0, 18.0 / 128.0, 9.0 / 128.0];

/// The warp of one cube coordinate, odd and increasing on [-1, 1]; close to `tan(x π/4)`.
#[inline]
pub fn warp(x: f64) -> f64 {
    let x2 = x * x;
    x * (WARP[0] + x2 * (WARP[1] + x2 * WARP[2]))
}

/// The warped coordinate of one component of a cube point. The division by a power of two is exact.
#[inline]
pub fn warp_component(c: i32) -> f64 {
    warp(f64::from(c) / f64::from(ONE))
}

/// Inverse of [`warp`] by Newton's method; accurate to rounding, used to look points up, never to decide bytes.
pub fn unwarp(y: f64) -> f64 {
    let mut x = y;
    for _ in 0..12 {
        let x2 = x * x;
        let slope = WARP[0] + x2 * (3.0 * WARP[1] + x2 * 5.0 * WARP[2]);
        x -= (warp(x) - y) / slope;
    }
    x
}

/// Unit direction of three warped components, always normalised in x, y, z order.
#[inline(always)]
pub fn normalise(x: f64, y: f64, z: f64) -> DVec3 {
    let length = (x * x + y * y + z * z).sqrt();
    DVec3::new(x / length, y / length, z / length)
}

/// Unit direction of a cube point.
#[inline]
pub fn direction(point: CubePoint) -> DVec3 {
    normalise(warp_component(point.x), warp_component(point.y), warp_component(point.z))
}

/// Unit direction of a site. Latitude and longitude in degrees; +Z is north, longitude 0 is +X, 90° east is +Y.
/// Used to aim cameras, not to decide bytes.
pub fn direction_at(latitude: f64, longitude: f64) -> DVec3 {
    let (lat, lon) = (latitude.to_radians(), longitude.to_radians());
    DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
}

/// Latitude and longitude in degrees of a direction (any length but zero).
pub fn latitude_longitude(direction: DVec3) -> (f64, f64) {
    let horizontal = direction.x.hypot(direction.y);
    (direction.z.atan2(horizontal).to_degrees(), direction.y.atan2(direction.x).to_degrees())
}

/// One of the six faces of the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Face(u8);

impl Face {
    /// All faces, in order +X, -X, +Y, -Y, +Z, -Z.
    pub const ALL: [Face; 6] = [Face(0), Face(1), Face(2), Face(3), Face(4), Face(5)];

    /// The face of an index below six.
    pub fn new(index: u8) -> Option<Face> {
        (index < 6).then_some(Face(index))
    }

    /// Position in [`Face::ALL`].
    pub fn index(self) -> u8 {
        self.0
    }

    /// The face whose outside is towards component `axis` with the sign of `positive`.
    pub fn of_axis(axis: usize, positive: bool) -> Face {
        Face(2 * axis as u8 + u8::from(!positive))
    }

    /// The cube axis this face looks along.
    pub fn normal_axis(self) -> usize {
        usize::from(self.0 / 2)
    }

    /// +1 or -1: which end of the normal axis.
    pub fn sign(self) -> i32 {
        1 - 2 * i32::from(self.0 % 2)
    }

    /// The cube axes of the face's two grid coordinates (i, j). Both run in the direction of growing cube coordinates, on
    /// every face, and i × j points outside.
    pub fn grid_axes(self) -> (usize, usize) {
        let w = self.normal_axis();
        let (a, b) = ((w + 1) % 3, (w + 2) % 3);
        if self.sign() > 0 {
            (a, b)
        } else {
            (b, a)
        }
    }

    /// The face a direction falls on (the lowest-numbered of several).
    pub fn containing(direction: DVec3) -> Face {
        let a = direction.abs();
        let axis = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        Face::of_axis(axis, direction[axis] >= 0.0)
    }

    /// Unit vector to the face's outside.
    pub fn normal(self) -> DVec3 {
        DVec3::AXES[self.normal_axis()] * f64::from(self.sign())
    }

    /// The face's warped coordinates (in [-1, 1] inside the face) of a direction in the face's half space.
    pub fn project(self, direction: DVec3) -> (f64, f64) {
        let (u, v) = self.grid_axes();
        let w = direction[self.normal_axis()].abs();
        (direction[u] / w, direction[v] / w)
    }

    /// The face's cube coordinates (in [-1, 1] inside the face) of a direction in the face's half space.
    pub fn coordinates(self, direction: DVec3) -> (f64, f64) {
        let (u, v) = self.project(direction);
        (unwarp(u), unwarp(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warp_keeps_the_ends_and_inverts() {
        assert_eq!(warp(1.0), 1.0);
        assert_eq!(warp(-1.0), -1.0);
        for k in -100..=100 {
            let x = f64::from(k) / 100.0;
            assert!((unwarp(warp(x)) - x).abs() < 1e-14);
        }
    }

    #[test]
    fn grid_axes_turn_outwards_on_every_face() {
        for face in Face::ALL {
            let (u, v) = face.grid_axes();
            let cross = DVec3::AXES[u].cross(DVec3::AXES[v]);
            assert_eq!(cross, face.normal());
        }
    }

    #[test]
    fn latitude_longitude_inverts_direction_at() {
        for (lat, lon) in [(0.0, 0.0), (47.5, 11.25), (-89.0, -170.0), (12.0, 179.5)] {
            let (a, b) = latitude_longitude(direction_at(lat, lon));
            assert!((a - lat).abs() < 1e-9 && (b - lon).abs() < 1e-9);
        }
    }
}
