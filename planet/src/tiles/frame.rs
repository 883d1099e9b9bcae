//! Where the numbers of a tile count from: an origin that single precision holds exactly, and a step that is a power of two.
//!
//! Vertices on a side of the patch are rounded outwards, onto or beyond the plane through that side and the planet's centre: tiles of
//! different steps then overlap by a step or two and leave no slit between them.

use crate::export::glb::MOST_STEPS;
use crate::globe::patch::{PatchId, Side};
use crate::globe::sphere::warp_component;
use glam::{DVec3, IVec3};

/// Bits of an origin's largest coordinate. Single precision has 24; four are left for what clients do with it.
const ANCHOR_BITS: i32 = 20;

/// Steps that rounding may move a vertex along an axis.
const ROUNDING_STEPS: f64 = 2.0;

/// Origin, step and sides of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Metres from the planet's centre.
    pub(super) anchor: DVec3,
    /// Metres.
    pub(super) step: f64,
    /// Unit vectors out of the patch across its sides, in the order of [`Side::ALL`].
    outward: [DVec3; 4],
}

impl Frame {
    /// The frame of a patch whose positions lie between two corners, in metres, or so many metres beyond them.
    pub(super) fn new(id: PatchId, [low, high]: [DVec3; 2], farther: f64) -> Frame {
        let centre = (low + high) / 2.0;
        let grain = power_above(centre.abs().max_element()) / f64::from(1 << ANCHOR_BITS);
        let anchor = (centre / grain).round() * grain;
        let reach = (high - anchor).abs().max((low - anchor).abs()).max_element() + farther;
        let mut step = power_above(reach / f64::from(MOST_STEPS));
        while reach / step + ROUNDING_STEPS > f64::from(MOST_STEPS) {
            step *= 2.0;
        }
        Frame { anchor, step, outward: outward(id) }
    }

    /// Steps to a point in metres from the planet's centre that lies on some sides, a bit each.
    pub(super) fn steps(&self, point: DVec3, sides: u8) -> IVec3 {
        let exact = (point - self.anchor) / self.step;
        if sides == 0 {
            return exact.round().as_ivec3();
        }
        let first = exact.floor().as_ivec3() - 1;
        let near = (0..64).map(|k| first + IVec3::new(k % 4, k / 4 % 4, k / 16));
        let is_outside = |p: &IVec3| {
            let p = self.metres(*p);
            Side::ALL.into_iter().filter(|side| sides & side.bit() != 0).all(|side| self.outward[side as usize].dot(p) >= 0.0)
        };
        let distance = |p: &IVec3| p.as_dvec3().distance_squared(exact);
        let nearest = near.filter(is_outside).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(exact.round().as_ivec3())
    }

    /// The way out of the patch across some sides, a bit each: a unit vector a side.
    pub(super) fn outward(&self, sides: u8) -> DVec3 {
        Side::ALL.into_iter().filter(|side| sides & side.bit() != 0).map(|side| self.outward[side as usize]).sum()
    }

    /// Metres from the planet's centre. Exact in double precision.
    pub(super) fn metres(&self, steps: IVec3) -> DVec3 {
        self.anchor + steps.as_dvec3() * self.step
    }
}

/// The smallest power of two that is at least so much.
fn power_above(least: f64) -> f64 {
    let power = least.max(f64::MIN_POSITIVE).log2().floor().exp2();
    if power < least {
        2.0 * power
    } else {
        power
    }
}

/// Unit vectors out of a patch across its sides, perpendicular to the planes through them and the planet's centre. From the warped
/// coordinates of the sides, which holds where corners lie too close together for a cross product.
fn outward(id: PatchId) -> [DVec3; 4] {
    let (face, (u, v)) = (id.face, id.face.grid_axes());
    Side::ALL.map(|side| {
        let (axis, end) = (if side.is_horizontal() { v } else { u }, i32::from(side.is_high()));
        let mut normal = DVec3::ZERO;
        normal[axis] = 1.0;
        normal[face.normal_axis()] = -warp_component(id.point(end, end, 1)[axis]) * f64::from(face.sign());
        normal.normalize() * if side.is_high() { 1.0 } else { -1.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::{direction, Face};

    #[test]
    fn origins_are_exact_in_single_precision_and_vertices_on_sides_lie_outside() {
        for (face, level, x, y) in [(0, 0, 0, 0), (3, 5, 7, 30), (5, 12, 100, 4095), (2, 21, 77, 1)] {
            let id = PatchId::new(Face::ALL[face], level, x, y).unwrap();
            let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            let points: Vec<(DVec3, u8)> = [(0, 0, 5), (4, 0, 6), (0, 4, 9), (4, 4, 10), (1, 0, 4), (4, 3, 2), (2, 2, 0)]
                .map(|(a, b, sides)| {
                    let position = direction(id.point(a, b, 4)) * (6_371_000.0 + 8.0 * f64::from(a));
                    bounds = [bounds[0].min(position), bounds[1].max(position)];
                    (position, sides)
                })
                .to_vec();
            let frame = Frame::new(id, bounds, 10.0);
            assert_eq!(frame.anchor.as_vec3().as_dvec3(), frame.anchor);
            assert_eq!(f64::from(frame.step as f32), frame.step);
            for (point, sides) in points {
                let steps = frame.steps(point, sides);
                assert!(steps.abs().max_element() <= MOST_STEPS);
                let back = frame.metres(steps);
                assert!(back.distance(point) <= 2.5 * frame.step, "{id}: {} steps", back.distance(point) / frame.step);
                for side in Side::ALL.into_iter().filter(|side| sides & side.bit() != 0) {
                    assert!(frame.outward[side as usize].dot(back) >= 0.0, "{id} {side:?}");
                }
                let inside = id.centre() * back.length();
                assert!(frame.outward.iter().all(|n| n.dot(inside) < 0.0), "{id}");
            }
        }
    }
}
