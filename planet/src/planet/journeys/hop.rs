//! A tour of all places. From one to the next the camera rises and sinks as van Wijk and Nuij (2003) zoom and pan: on the shortest way
//! where a metre counts as much as the altitude is low, which is half a circle as high as half the way is long.

use super::{pitch_at, short_way, smooth, Circle, Stop, ORBIT};
use crate::draw::camera_path::Keyframe;
use crate::planet::Planet;

/// Altitudes of way a second, on average.
const PACE: f64 = 0.9;

/// Seconds at a place, and degrees that the camera turns there.
const STAY_S: f64 = 6.0;
const STAY_TURN: f64 = 24.0;

/// Keyframes of a hop, and the share of it in which the camera turns from what it looked at, or to what it will.
const STEPS: u32 = 12;
const TURNS: f64 = 0.4;

/// Radians below which a hop goes straight up or down.
const SAME_SITE: f64 = 1e-7;

/// Keyframes of a tour of some stops, at least one.
pub(super) fn tour(planet: &Planet, stops: &[Stop]) -> Vec<Keyframe> {
    let radius = planet.recipe.radius;
    let Some(first) = stops.first() else { return Vec::new() };
    let mut here = Stop { altitude_m: ORBIT * radius, pitch: -90.0, ..*first };
    let (mut keyframes, mut time_s) = (vec![here.keyframe(0.0)], 0.0);
    for stop in stops {
        let there = stop.turned(-STAY_TURN / 2.0);
        let hop = Hop::new(&here, &there, radius);
        let seconds = (hop.length / PACE).max(1.0);
        let step = |k: u32| hop.at(f64::from(k) / f64::from(STEPS)).keyframe(time_s + seconds * f64::from(k) / f64::from(STEPS));
        keyframes.extend((1..STEPS).map(step));
        time_s += seconds;
        keyframes.push(there.keyframe(time_s));
        here = stop.turned(STAY_TURN / 2.0);
        time_s += STAY_S;
        keyframes.push(here.keyframe(time_s));
    }
    keyframes
}

/// The way from one stop to another.
struct Hop {
    ends: [Stop; 2],
    circle: Circle,
    radius: f64,
    /// Metres over the ground.
    way: f64,
    /// Where on the half circle the way begins.
    begin: f64,
    /// Length of the way in altitudes.
    length: f64,
}

impl Hop {
    fn new(from: &Stop, to: &Stop, radius: f64) -> Hop {
        let circle = Circle::between(from.up, to.up);
        let (low, high) = (from.altitude_m, to.altitude_m);
        let way = radius * circle.angle.max(SAME_SITE);
        let squares = high * high - low * low;
        let begin = -((squares + way * way) / (2.0 * low * way)).asinh();
        let end = -((squares - way * way) / (2.0 * high * way)).asinh();
        Hop { ends: [*from, *to], circle, radius, way, begin, length: end - begin }
    }

    /// The camera at a share of the duration.
    fn at(&self, share: f64) -> Stop {
        let [from, to] = &self.ends;
        let along = self.begin + self.length * smooth(share);
        let altitude_m = from.altitude_m * self.begin.cosh() / along.cosh();
        let done = (from.altitude_m * (self.begin.cosh() * along.tanh() - self.begin.sinh()) / self.way).clamp(0.0, 1.0);
        let [leaving, arriving] = [1.0 - smooth(share / TURNS), 1.0 - smooth((1.0 - share) / TURNS)];
        let pitch = leaving * from.pitch + arriving * to.pitch + (1.0 - leaving - arriving) * pitch_at(altitude_m, self.radius);
        let heading = if self.circle.angle < SAME_SITE {
            from.heading + short_way(to.heading - from.heading) * smooth(share)
        } else {
            let turn = |stop: &Stop, share: f64| short_way(stop.heading - self.circle.heading(share));
            self.circle.heading(done) + leaving * turn(from, 0.0) + arriving * turn(to, 1.0)
        };
        Stop { up: self.circle.at(done), altitude_m, heading, pitch }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn stop(up: DVec3, altitude_m: f64) -> Stop {
        Stop { up, altitude_m, heading: 30.0, pitch: -4.0 }
    }

    #[test]
    fn hops_rise_to_half_their_way_and_end_where_they_should() {
        let hop = Hop::new(&stop(DVec3::X, 500.0), &stop(DVec3::Y, 2000.0), 6e6);
        for (share, up, altitude_m) in [(0.0, DVec3::X, 500.0), (1.0, DVec3::Y, 2000.0)] {
            let found = hop.at(share);
            assert!(found.up.distance(up) < 1e-9 && (found.altitude_m / altitude_m - 1.0).abs() < 1e-6, "{found:?}");
            assert!(short_way(found.heading - 30.0).abs() < 1e-6 && (found.pitch + 4.0).abs() < 1e-9, "{found:?}");
        }
        let highest = (0..=1000).map(|k| hop.at(f64::from(k) / 1000.0).altitude_m).fold(0.0, f64::max);
        assert!((highest / (hop.way / 2.0) - 1.0).abs() < 0.01, "{highest}");
    }

    #[test]
    fn hops_over_one_site_go_straight_down() {
        let hop = Hop::new(&stop(DVec3::X, 2e7), &stop(DVec3::X, 50.0), 6e6);
        assert!((hop.length - (2e7f64 / 50.0).ln()).abs() < 1e-6, "{}", hop.length);
        let mut above = f64::MAX;
        for k in 0..=100 {
            let found = hop.at(f64::from(k) / 100.0);
            assert!(found.up.distance(DVec3::X) < 1e-6 && found.altitude_m < above * (1.0 + 1e-12));
            above = found.altitude_m;
        }
    }
}
