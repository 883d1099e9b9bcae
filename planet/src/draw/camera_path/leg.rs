//! The way over the ground between two keyframes, and a level direction that is carried along it. In: unit directions, velocities and a
//! level direction. Out: the same in between.
//!
//! The way is a Bézier curve whose straight lines are great circles (Shoemake 1985, of directions instead of rotations), so that no
//! direction, no pole and no corner of a face is like no other. The level direction is carried along the great circle between the ends,
//! and from there along another to the way: at both ends it turns no more than parallel transport along the way would, whatever the way.

use super::curve::speed_between;
use glam::{DQuat, DVec3};

/// The way from one keyframe to the next.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    points: [DVec3; 4],
    ahead: DVec3,
}

impl Leg {
    /// From a unit direction to another, not its opposite, with velocities in radians a leg; `ahead` is a level unit direction at the start.
    pub(super) fn new([from, to]: [DVec3; 2], [leaving, arriving]: [DVec3; 2], ahead: DVec3) -> Leg {
        Leg { points: [from, moved(from, leaving / 3.0), moved(to, -arriving / 3.0), to], ahead }
    }

    /// Where the way is, and the carried direction, at a share of the leg.
    pub(super) fn at(&self, share: f64) -> (DVec3, DVec3) {
        let [a, b, c, d] = self.points;
        let [ab, bc, cd] = [between(a, b, share), between(b, c, share), between(c, d, share)];
        let up = between(between(ab, bc, share), between(bc, cd, share), share);
        let chord = between(a, d, share);
        let carried = DQuat::from_rotation_arc(chord, up) * (DQuat::from_rotation_arc(a, chord) * self.ahead);
        (up, level(carried, up))
    }
}

/// Velocity at a keyframe, in radians a unit of the knots, of the directions before, at and after it and the knots between: along the mean
/// of both ways, as fast as [`speed_between`] has it, less where the way bends, and 0 where it turns back.
pub(super) fn velocity(before: DVec3, here: DVec3, after: DVec3, steps: [f64; 2]) -> DVec3 {
    let [came, goes] = [-way(here, before) / steps[0], way(here, after) / steps[1]];
    let (Some(from), Some(to)) = (came.try_normalize(), goes.try_normalize()) else { return DVec3::ZERO };
    // The half of this sum is as long as the cosine of half the bend.
    (from + to) * (0.5 * speed_between([came.length(), goes.length()], steps))
}

/// The level unit vector nearest to a vector at a place; any where it is vertical.
pub(super) fn level(vector: DVec3, up: DVec3) -> DVec3 {
    vector.reject_from_normalized(up).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector())
}

/// The velocity that leads from one unit direction to another in a unit of time.
pub(super) fn way(from: DVec3, to: DVec3) -> DVec3 {
    let across = from.cross(to);
    let sine = across.length();
    if sine == 0.0 {
        return DVec3::ZERO;
    }
    across.cross(from) * (sine.atan2(from.dot(to)) / sine)
}

/// Where a velocity leads in a unit of time.
fn moved(from: DVec3, velocity: DVec3) -> DVec3 {
    let angle = velocity.length();
    if angle == 0.0 {
        return from;
    }
    (from * angle.cos() + velocity * (angle.sin() / angle)).normalize()
}

/// The unit direction a share of the way from one to another.
fn between(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    moved(from, way(from, to) * share)
}

/// Radians between two unit directions.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
