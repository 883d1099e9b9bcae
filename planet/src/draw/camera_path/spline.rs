//! The smooth curve through keyframes, over knots of any kind. In: keyframes and a knot for each. Out: where the camera is at a knot.

use super::curve::{Between, Curve, Ends};
use super::leg::{self, Leg};
use super::{Keyframe, PathError, Waypoint};
use crate::draw::view_line::Stand;
use glam::{DQuat, DVec3};

/// Metres above the datum where heights begin to be interpolated by their logarithm; nearer to it they are by themselves.
const NEAR_DATUM_M: f64 = 1000.0;

/// Most degrees over the ground from one keyframe to the next: beyond, which way they go would be chance.
const FARTHEST: f64 = 179.0;

/// A curve through keyframes.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    knots: Vec<f64>,
    legs: Vec<Leg>,
    /// How far above the planet, as [`rung`] has it.
    rungs: Curve,
    above_datum: bool,
    /// Radians clockwise that the camera has turned, since the start, against the direction that legs carry.
    turns: Curve,
    pitches: Curve,
    fovs: Curve,
}

impl Spline {
    /// The curve through as many waypoints as there are rising knots, at least two. Their stands are all of one kind.
    pub(super) fn new(points: &[Waypoint], knots: Vec<f64>, ends: Ends) -> Spline {
        let curve = |values: Vec<f64>| Curve::new(&knots, values, ends);
        let velocities: Vec<DVec3> = (0..points.len()).map(|k| velocity(points, &knots, k, ends)).collect();
        let leg = |k: usize| {
            let step = knots[k + 1] - knots[k];
            Leg::new([points[k].up, points[k + 1].up], [velocities[k] * step, velocities[k + 1] * step], points[k].ahead)
        };
        Spline {
            legs: (0..points.len() - 1).map(leg).collect(),
            rungs: curve(points.iter().map(|point| rung(point.stand)).collect()),
            above_datum: matches!(points[0].stand, Stand::Height(_)),
            turns: curve(turns(points)),
            pitches: curve(points.iter().map(|point| point.pitch).collect()),
            fovs: curve(points.iter().map(|point| point.fov).collect()),
            knots,
        }
    }

    /// First and last knot.
    pub(super) fn span(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Knots at equal steps, `each` to a leg, the last one too.
    pub(super) fn samples(&self, each: usize) -> impl Iterator<Item = f64> + '_ {
        let within = move |pair: &[f64]| {
            let [from, to] = [pair[0], pair[1]];
            (0..each).map(move |k| from + (to - from) * (k as f64 / each as f64))
        };
        self.knots.windows(2).flat_map(within).chain([self.span().1])
    }

    /// Where the camera is at a knot, and radians that it has turned until there; its time is the knot.
    pub(super) fn at(&self, knot: f64) -> (Waypoint, f64) {
        let place = Between::of(&self.knots, knot);
        let (up, carried) = self.legs[place.from].at(place.share);
        let turned = self.turns.at(place);
        let (sine, cosine) = (turned - self.turns.knot(place.from)).sin_cos();
        let ahead = leg::level(carried * cosine + carried.cross(up) * sine, up);
        let rung = self.rungs.at(place);
        let stand = if self.above_datum { Stand::Height(NEAR_DATUM_M * rung.sinh()) } else { Stand::Altitude(rung.exp()) };
        let (pitch, fov) = (self.pitches.at(place), self.fovs.at(place));
        (Waypoint { time_s: knot, up, stand, ahead, pitch, fov }, turned)
    }
}

/// Waypoints of checked keyframes.
pub(super) fn waypoints(keyframes: &[Keyframe]) -> Result<Vec<Waypoint>, PathError> {
    let points: Vec<Waypoint> = keyframes.iter().map(Waypoint::of).collect();
    let apart = |pair: &[Waypoint]| leg::angle(pair[0].up, pair[1].up).to_degrees();
    match points.windows(2).position(|pair| apart(pair) > FARTHEST) {
        Some(k) => Err(PathError::Opposite { number: k + 1, degrees: apart(&points[k..]), most: FARTHEST }),
        None => Ok(points),
    }
}

/// Radians clockwise that a camera turns to each of some waypoints, since the first: from each to the next the short way.
pub(super) fn turns(points: &[Waypoint]) -> Vec<f64> {
    let turn = |pair: &[Waypoint]| {
        let (from, to) = (pair[0], pair[1]);
        let carried = leg::level(DQuat::from_rotation_arc(from.up, to.up) * from.ahead, to.up);
        to.ahead.dot(carried.cross(to.up)).atan2(to.ahead.dot(carried))
    };
    let summed = points.windows(2).scan(0.0, |sum, pair| {
        *sum += turn(pair);
        Some(*sum)
    });
    std::iter::once(0.0).chain(summed).collect()
}

fn velocity(points: &[Waypoint], knots: &[f64], k: usize, ends: Ends) -> DVec3 {
    let last = points.len() - 1;
    let mean = |k: usize| leg::way(points[k].up, points[k + 1].up) / (knots[k + 1] - knots[k]);
    match ends {
        Ends::Soft if k == 0 || k == last => DVec3::ZERO,
        Ends::Running if k == 0 => mean(0),
        Ends::Running if k == last => -leg::way(points[last].up, points[last - 1].up) / (knots[last] - knots[last - 1]),
        _ => {
            let steps = [knots[k] - knots[k - 1], knots[k + 1] - knots[k]];
            leg::velocity(points[k - 1].up, points[k].up, points[k + 1].up, steps)
        }
    }
}

/// What is interpolated of a stand: altitudes by their logarithm; heights, which may be 0 and less, by theirs only high up.
fn rung(stand: Stand) -> f64 {
    match stand {
        Stand::Altitude(metres) => metres.ln(),
        Stand::Height(metres) => (metres / NEAR_DATUM_M).asinh(),
    }
}
