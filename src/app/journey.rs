//! A flight to another pose: up, over and down again, as fast as the eye bears (van Wijk and Nuij 2003, "Smooth and efficient zooming and
//! panning"). In: two poses over a surface. Out: the pose at a time between.

use super::orbit_camera::resting_pitch;
use super::pose::Pose;
use super::surface::Surface;
use glam::{DQuat, DVec3};

/// How much a flight prefers to rise over going far: van Wijk and Nuij found people to like 1.42.
const RHO: f64 = 1.42;
/// Lengths of the path, in their measure, each second.
const PACE: f64 = 1.5;
/// Shortest and longest flight in seconds.
const SECONDS: (f64, f64) = (0.5, 9.0);
/// Altitudes in metres below which they count as this, so that logarithms stay small.
const LEAST_ALTITUDE: f64 = 2.0;

/// A flight under way.
pub(super) struct Journey {
    from: Pose,
    to: Pose,
    way: Way,
    /// Metres from the planet's centre to the surface below both ends.
    surface: [f64; 2],
    /// Radians to turn on the way, beside following the great circle.
    turn: f64,
    seconds: f64,
    passed: f64,
}

/// The way in a plane: how far along the ground, and how high, both in metres.
struct Way {
    width: f64,
    heights: [f64; 2],
    length: f64,
    begin: f64,
}

impl Journey {
    /// From a pose to another.
    pub(super) fn new(from: Pose, to: Pose, surface: &dyn Surface) -> Journey {
        let below = [from, to].map(|pose| surface.radius(pose.up()));
        let heights = [from.altitude(surface), to.altitude(surface)].map(|altitude| altitude.max(LEAST_ALTITUDE));
        let way = Way::new(from.up().angle_between(to.up()) * below[0], heights);
        let carried = arc(from.up(), to.up(), 1.0) * from.ahead;
        let turn = carried.cross(to.ahead).dot(to.up()).atan2(carried.dot(to.ahead));
        let seconds = (way.length / PACE).clamp(SECONDS.0, SECONDS.1);
        Journey { from, to, way, surface: below, turn, seconds, passed: 0.0 }
    }

    /// The pose after `seconds` more. None when it has come to the end; the last pose is exactly the one asked for.
    pub(super) fn step(&mut self, seconds: f64) -> Option<Pose> {
        if self.passed >= self.seconds {
            return None;
        }
        self.passed += seconds;
        if self.passed >= self.seconds {
            return Some(self.to);
        }
        Some(self.at(eased(self.passed / self.seconds)))
    }

    fn at(&self, share: f64) -> Pose {
        let (along, height) = self.way.at(share);
        let rotation = arc(self.from.up(), self.to.up(), along);
        let up = (rotation * self.from.up()).normalize();
        let surface = self.surface[0] + (self.surface[1] - self.surface[0]) * along;
        let ahead = DQuat::from_axis_angle(up, self.turn * share) * (rotation * self.from.ahead);
        let mean = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * share;
        // Who is high looks down, whatever both ends look at.
        let rest = |height: f64| resting_pitch(height, self.surface[0]);
        let lower = rest(height) - mean(self.way.heights.map(rest));
        let pitch = mean([self.from.pitch, self.to.pitch]) + lower;
        Pose::new(up * (surface + height), ahead, pitch)
    }
}

impl Way {
    fn new(width: f64, heights: [f64; 2]) -> Way {
        let [w0, w1] = heights;
        let mut way = Way { width, heights, length: (w1 / w0).ln().abs() / RHO, begin: 0.0 };
        // Nearly straight up or down.
        if width > 1e-3 * w0.max(w1) {
            let b = |w: f64, sign: f64| (w1 * w1 - w0 * w0 + sign * RHO.powi(4) * width * width) / (2.0 * w * RHO * RHO * width);
            let r = |b: f64| -(b.asinh());
            way.begin = r(b(w0, 1.0));
            way.length = (r(b(w1, -1.0)) - way.begin) / RHO;
        } else {
            way.width = 0.0;
        }
        way
    }

    /// How much of the way along the ground is behind, and the height, after a share of the whole.
    fn at(&self, share: f64) -> (f64, f64) {
        let [w0, w1] = self.heights;
        if self.width == 0.0 {
            return (share, w0 * (w1 / w0).powf(share));
        }
        let s = RHO * share * self.length + self.begin;
        let along = w0 / (RHO * RHO) * (self.begin.cosh() * s.tanh() - self.begin.sinh()) / self.width;
        (along.clamp(0.0, 1.0), w0 * self.begin.cosh() / s.cosh())
    }
}

/// A share of the rotation from one unit direction to another.
fn arc(from: DVec3, to: DVec3, share: f64) -> DQuat {
    DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(from, to), share)
}

fn eased(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::{pose, Ball, RADIUS};
    use super::*;
    use terrane_planet::draw::view::Camera;

    fn flown(from: Pose, to: Pose, step: f64) -> Vec<Pose> {
        let mut journey = Journey::new(from, to, &Ball);
        std::iter::from_fn(|| journey.step(step)).collect()
    }

    fn over(direction: DVec3, altitude_m: f64, heading: f64, pitch: f64) -> Pose {
        Pose::of_camera(&Camera::looking(direction.normalize() * (RADIUS + altitude_m), heading, pitch, 0.9, [800, 600]))
    }

    #[test]
    fn a_journey_ends_exactly_where_it_was_to_and_begins_without_a_jump() {
        let begin = pose(2e7, 10.0, -90.0);
        for end in
            [over(DVec3::new(-0.3, 0.8, 0.1), 300.0, 200.0, -10.0), over(-begin.up(), 5e3, 0.0, -30.0), pose(100.0, 10.0, -5.0)]
        {
            let poses = flown(begin, end, 1.0 / 240.0);
            assert_eq!(poses.last(), Some(&end));
            assert!(poses[0].position.distance(begin.position) < 0.01 * begin.altitude(&Ball));
            assert!((poses[0].pitch - begin.pitch).abs() < 0.01);
        }
    }

    #[test]
    fn a_way_along_the_ground_rises_and_never_jumps_by_more_than_a_little_of_its_altitude() {
        let (begin, end) = (pose(500.0, 0.0, -10.0), over(DVec3::new(0.8, 0.0, 0.6), 800.0, 90.0, -10.0));
        let poses = flown(begin, end, 1.0 / 480.0);
        let highest = poses.iter().map(|pose| pose.altitude(&Ball)).fold(0.0, f64::max);
        assert!(highest > 1e6, "{highest}");
        for pair in poses.windows(2) {
            let altitude = pair[0].altitude(&Ball).max(pair[1].altitude(&Ball));
            assert!(pair[0].position.distance(pair[1].position) < 0.05 * altitude, "{altitude}");
            assert!(pair[0].ahead.distance(pair[1].ahead) < 0.05 && (pair[0].pitch - pair[1].pitch).abs() < 0.05);
            assert!(pair[0].altitude(&Ball) > 400.0);
        }
    }

    #[test]
    fn no_journey_takes_longer_than_anyone_waits() {
        let poses = flown(pose(2.0, 0.0, 0.0), over(-pose(2.0, 0.0, 0.0).up(), 2.0, 0.0, 0.0), 0.1);
        assert!((poses.len() as f64) * 0.1 <= SECONDS.1 + 0.1);
    }
}
