//! A constant pace: how far a camera gets is measured by what it flies over, so that a descent from orbit takes each halving of the
//! altitude in equal times. In: a path's keyframes and the planet's radius. Out: the knot at every share of the duration.
//!
//! The measure is that in which van Wijk and Nuij (2003) zoom and pan: way over altitude, and for what turns on the spot, radians.

use super::curve::{Between, Curve, Ends};
use super::leg;
use super::spline::{turns, Spline};
use super::Waypoint;
use crate::draw::view_line::Stand;

/// Share of the duration in which the camera gets up to its speed, and the same in which it comes to rest.
pub(super) const EASE: f64 = 0.1;

/// Heights count as altitudes of at least this share of the planet's radius: they may be less than nothing.
pub(super) const LEAST_HEIGHT: f64 = 1e-4;

/// Steps a leg in which its length is measured.
const STEPS: usize = 32;

/// Which knot is when.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    /// Lengths from the start, rising.
    lengths: Vec<f64>,
    /// Knots there.
    knots: Curve,
}

impl Clock {
    /// A curve through waypoints at a constant pace, over a planet of `radius` metres; `None` if they are all the same.
    pub(super) fn new(points: &[Waypoint], radius: f64) -> Option<(Spline, Clock)> {
        let turned = turns(points);
        let (mut kept, mut knots) = (vec![points[0]], vec![0.0]);
        for k in 1..points.len() {
            let length = length(&points[k - 1], &points[k], turned[k] - turned[k - 1], radius);
            if length > 0.0 {
                kept.push(points[k]);
                knots.push(knots[knots.len() - 1] + length);
            }
        }
        if kept.len() < 2 {
            return None;
        }
        let spline = Spline::new(&kept, knots, Ends::Running);
        let clock = Clock::along(&spline, radius);
        Some((spline, clock))
    }

    fn along(spline: &Spline, radius: f64) -> Clock {
        let mut before = spline.at(spline.span().0);
        let (mut lengths, mut knots) = (vec![0.0], vec![spline.span().0]);
        for knot in spline.samples(STEPS).skip(1) {
            let now = spline.at(knot);
            let longer = lengths[lengths.len() - 1] + length(&before.0, &now.0, now.1 - before.1, radius);
            if longer > lengths[lengths.len() - 1] {
                lengths.push(longer);
                knots.push(knot);
                before = now;
            }
        }
        let knots = Curve::new(&lengths, knots, Ends::Running);
        Clock { lengths, knots }
    }

    /// The knot at a share of the duration, 0 to 1.
    pub(super) fn knot(&self, share: f64) -> f64 {
        let whole = self.lengths[self.lengths.len() - 1];
        self.knots.at(Between::of(&self.lengths, whole * eased(share)))
    }
}

/// The part of the way that is done at a share of the duration: evenly, but for an even gain of speed at the start and loss at the end.
fn eased(share: f64) -> f64 {
    let start = |share: f64| share * share / (2.0 * EASE);
    let done = if share < EASE {
        start(share)
    } else if share > 1.0 - EASE {
        1.0 - EASE - start(1.0 - share)
    } else {
        share - EASE / 2.0
    };
    done / (1.0 - EASE)
}

/// The length of a short way that turns by some radians.
fn length(a: &Waypoint, b: &Waypoint, turn: f64, radius: f64) -> f64 {
    let (Stand::Altitude(low) | Stand::Height(low), Stand::Altitude(high) | Stand::Height(high)) = (a.stand, b.stand);
    let altitude = |stand: Stand| match stand {
        Stand::Altitude(metres) => metres,
        Stand::Height(metres) => metres.max(LEAST_HEIGHT * radius),
    };
    let over = mean(altitude(a.stand), altitude(b.stand));
    let along = radius * leg::angle(a.up, b.up) / over;
    let pitch = (b.pitch - a.pitch).to_radians();
    along.hypot((high - low) / over).hypot(turn).hypot(pitch)
}

/// The logarithmic mean of two lengths: a rise between them over it is the logarithm of their ratio.
fn mean(a: f64, b: f64) -> f64 {
    let ratio = (b / a).ln();
    if ratio.abs() < 1e-6 {
        0.5 * (a + b)
    } else {
        (b - a) / ratio
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn easing_is_smooth_and_whole() {
        assert_eq!([0.0, 0.5, 1.0].map(eased), [0.0, 0.5, 1.0]);
        let speed = |share: f64| (eased(share + 1e-7) - eased(share - 1e-7)) / 2e-7;
        for seam in [EASE, 1.0 - EASE] {
            assert!((speed(seam - 1e-6) - speed(seam + 1e-6)).abs() < 1e-3, "{seam}");
        }
    }
}
