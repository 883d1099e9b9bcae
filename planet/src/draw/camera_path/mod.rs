//! Camera paths: keyframes over time, and the smooth curve through them. In: keyframes. Out: where the camera is at any time.
//!
//! Over the ground the way is a spline of great circles, and the camera's heading is counted against a direction that is carried along
//! it (`leg.rs`), so that neither knows poles. All other quantities follow cubic Hermite curves with the tangents of Fritsch and Carlson
//! (1980), which never overshoot (`curve.rs`): between two keyframes altitude, pitch and field of view stay between their values, so a
//! path whose keyframes clear the ground by some altitude clears it by that everywhere. Position, view direction and their speeds are
//! continuous. Altitudes are interpolated by their logarithms, headings the short way. A path has either altitudes or heights: what
//! should lie between the two only the ground in between could say.

mod carried;
mod curve;
mod keyframe;
mod leg;
mod pace;
mod route;
mod spline;
#[cfg(test)]
mod tests;
mod waypoint;

pub use carried::Carried;
pub use keyframe::Keyframe;
pub use route::{Pace, Route};
pub use waypoint::Waypoint;

use curve::Ends;
use pace::Clock;
use spline::Spline;
use thiserror::Error;

/// Why keyframes make no path.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PathError {
    /// Too few.
    #[error("{found} keyframes, expected at least 2")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// Not in order.
    #[error("keyframe {number} is at {time_s} s, expected a time after that of the one before; sort them")]
    Order {
        /// Which one, from 0.
        number: usize,
        /// Its time.
        time_s: f64,
    },
    /// A value that no camera has.
    #[error("keyframe {number}: {what} is {found}, expected {expected}")]
    Value {
        /// Which one, from 0.
        number: usize,
        /// Which quantity.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it can be.
        expected: &'static str,
    },
    /// Altitudes and heights in one path.
    #[error("keyframe {number} has {found}, expected {expected} as the first one has; what lies between the two is not defined")]
    Mixed {
        /// Which one, from 0.
        number: usize,
        /// The key that it has.
        found: &'static str,
        /// The key that the first keyframe has.
        expected: &'static str,
    },
    /// A way that any great circle would do for.
    #[error("keyframe {number} is {degrees:.1} degrees from the one before, expected at most {most}; put one between that says which way")]
    Opposite {
        /// Which one, from 0.
        number: usize,
        /// Degrees over the ground.
        degrees: f64,
        /// The most that there may be.
        most: f64,
    },
}

/// A path through at least two keyframes.
#[derive(Clone, Debug)]
pub struct CameraPath {
    spline: Spline,
    /// Times of the first and the last keyframe.
    times: (f64, f64),
    /// At a constant pace: which of the spline's knots is when. Else knots are times.
    clock: Option<Clock>,
}

impl CameraPath {
    /// The path that passes keyframes at their times, from rest to rest.
    ///
    /// # Errors
    /// For fewer than two, times that do not grow, values that no camera has, altitudes among heights, and keyframes on opposite sides of
    /// the planet.
    pub fn new(keyframes: &[Keyframe]) -> Result<CameraPath, PathError> {
        keyframe::check(keyframes)?;
        let points = spline::waypoints(keyframes)?;
        let times: Vec<f64> = keyframes.iter().map(|keyframe| keyframe.time_s).collect();
        let span = (times[0], times[times.len() - 1]);
        Ok(CameraPath { spline: Spline::new(&points, times, Ends::Soft), times: span, clock: None })
    }

    /// The path over a planet of a radius in metres that passes keyframes in their order and takes as long as they say, at a constant
    /// pace: of length ds² = (dx² + dz²) / h² + dψ² + dθ², for the way dx over the ground of the datum, the way dz up, the altitude h, and
    /// the radians dψ and dθ by which heading and pitch turn, equal parts take equal times. For keyframes with heights h is the height
    /// above the datum, or a ten-thousandth of the radius if that is more. In the first tenth of the duration the speed grows evenly
    /// from nothing, in the last it falls evenly to nothing. Keyframes that repeat the one before count once.
    ///
    /// # Errors
    /// As [`CameraPath::new`].
    pub fn at_constant_pace(keyframes: &[Keyframe], radius_m: f64) -> Result<CameraPath, PathError> {
        let timed = CameraPath::new(keyframes)?;
        let paced = Clock::new(&spline::waypoints(keyframes)?, radius_m);
        Ok(match paced {
            Some((spline, clock)) => CameraPath { spline, times: timed.times, clock: Some(clock) },
            None => timed,
        })
    }

    /// Times of the first and the last keyframe, in seconds.
    pub fn span(&self) -> (f64, f64) {
        self.times
    }

    /// Where the camera is at a time; times outside the span are those of its ends.
    pub fn at(&self, time_s: f64) -> Waypoint {
        let (first, last) = self.times;
        let time_s = time_s.clamp(first, last);
        let knot = self.clock.as_ref().map_or(time_s, |clock| clock.knot((time_s - first) / (last - first)));
        Waypoint { time_s, ..self.spline.at(knot).0 }
    }
}
