//! Camera paths: keyframes over time, and the smooth curve through them.
//!
//! Each quantity follows a cubic Hermite curve through its keyframes with the tangents of Fritsch and Carlson (1980), which
//! never overshoots: between two keyframes every quantity stays between their values, so a path whose keyframes clear the ground
//! by some height clears it by that height everywhere. Altitudes are interpolated by their logarithms, angles the short way.

use serde::Deserialize;
use thiserror::Error;

/// Where a camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Seconds since the start of the path.
    pub time_s: f64,
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Metres above the ground or the sea.
    pub altitude_m: f64,
    /// Degrees clockwise from north.
    pub heading: f64,
    /// Degrees above the horizontal.
    pub pitch: f64,
    /// Vertical field of view in degrees.
    pub fov: f64,
}

/// Number of quantities of a keyframe that are interpolated.
const QUANTITIES: usize = 6;

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
}

/// Legal values: name, how to get it, least, most, in words.
type Rule = (&'static str, fn(&Keyframe) -> f64, f64, f64, &'static str);

const RULES: [Rule; 7] = [
    ("time_s", |k| k.time_s, 0.0, 1e6, "0 to 1e6 seconds"),
    ("latitude", |k| k.latitude, -90.0, 90.0, "-90 to 90 degrees"),
    ("longitude", |k| k.longitude, -360.0, 360.0, "-360 to 360 degrees"),
    ("altitude_m", |k| k.altitude_m, 0.5, 1e9, "0.5 to 1e9 metres"),
    ("heading", |k| k.heading, -360.0, 360.0, "-360 to 360 degrees"),
    ("pitch", |k| k.pitch, -90.0, 90.0, "-90 to 90 degrees"),
    ("fov", |k| k.fov, 7.0, 140.0, "7 to 140 degrees"),
];

/// A path through at least two keyframes.
#[derive(Clone, Debug)]
pub struct CameraPath {
    times: Vec<f64>,
    values: Vec<[f64; QUANTITIES]>,
    tangents: Vec<[f64; QUANTITIES]>,
}

impl CameraPath {
    /// The path through keyframes.
    ///
    /// # Errors
    /// For fewer than two, times that do not grow, and values that no camera has.
    pub fn new(keyframes: &[Keyframe]) -> Result<CameraPath, PathError> {
        check(keyframes)?;
        let times: Vec<f64> = keyframes.iter().map(|k| k.time_s).collect();
        let mut values: Vec<[f64; QUANTITIES]> = keyframes.iter().map(quantities).collect();
        for k in 1..values.len() {
            for angle in [1, 3] {
                values[k][angle] = values[k - 1][angle] + short_way(values[k][angle] - values[k - 1][angle]);
            }
        }
        let mut tangents = vec![[0.0; QUANTITIES]; values.len()];
        for q in 0..QUANTITIES {
            let line: Vec<f64> = values.iter().map(|v| v[q]).collect();
            for (tangent, t) in tangents.iter_mut().zip(monotone_tangents(&times, &line)) {
                tangent[q] = t;
            }
        }
        Ok(CameraPath { times, values, tangents })
    }

    /// Times of the first and the last keyframe, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// Where the camera is at a time; times outside the span are those of its ends.
    pub fn at(&self, time_s: f64) -> Keyframe {
        let (first, last) = self.span();
        let time = time_s.clamp(first, last);
        let after = self.times.partition_point(|&t| t <= time).clamp(1, self.times.len() - 1);
        let (from, step) = (after - 1, self.times[after] - self.times[after - 1]);
        let s = (time - self.times[from]) / step;
        let value = |q: usize| {
            let [a, b] = [self.values[from][q], self.values[after][q]];
            let [u, v] = [self.tangents[from][q] * step, self.tangents[after][q] * step];
            let cubic = a + (b - a) * s * s * (3.0 - 2.0 * s) + (u * (1.0 - s) - v * s) * s * (1.0 - s);
            cubic.clamp(a.min(b), a.max(b))
        };
        let [latitude, longitude, altitude, heading, pitch, fov] = std::array::from_fn(value);
        let [longitude, heading] = [longitude, heading].map(short_way);
        Keyframe { time_s: time, latitude, longitude, altitude_m: altitude.exp(), heading, pitch, fov }
    }
}

fn check(keyframes: &[Keyframe]) -> Result<(), PathError> {
    if keyframes.len() < 2 {
        return Err(PathError::TooFew { found: keyframes.len() });
    }
    for (number, keyframe) in keyframes.iter().enumerate() {
        for (what, value, least, most, expected) in RULES {
            let found = value(keyframe);
            if !(least..=most).contains(&found) {
                return Err(PathError::Value { number, what, found, expected });
            }
        }
        if number > 0 && keyframe.time_s <= keyframes[number - 1].time_s {
            return Err(PathError::Order { number, time_s: keyframe.time_s });
        }
    }
    Ok(())
}

fn quantities(k: &Keyframe) -> [f64; QUANTITIES] {
    [k.latitude, k.longitude, k.altitude_m.ln(), k.heading, k.pitch, k.fov]
}

/// An angle in degrees within -180 and 180.
fn short_way(angle: f64) -> f64 {
    angle - 360.0 * (angle / 360.0).round()
}

/// Tangents at every point of a line such that the cubics between them are monotone where the points are: 0 at turns, else the
/// weighted harmonic mean of the slopes on both sides; 0 at the ends too, so that the camera starts and stops softly.
fn monotone_tangents(times: &[f64], line: &[f64]) -> Vec<f64> {
    let slope = |k: usize| (line[k + 1] - line[k]) / (times[k + 1] - times[k]);
    let inner = |k: usize| {
        let (before, after) = (slope(k - 1), slope(k));
        let (left, right) = (times[k] - times[k - 1], times[k + 1] - times[k]);
        let (a, b) = (2.0 * right + left, right + 2.0 * left);
        if before * after <= 0.0 {
            0.0
        } else {
            (a + b) / (a / before + b / after)
        }
    };
    (0..line.len()).map(|k| if k == 0 || k + 1 == line.len() { 0.0 } else { inner(k) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time_s: f64, longitude: f64, altitude_m: f64, heading: f64) -> Keyframe {
        Keyframe { time_s, latitude: 10.0, longitude, altitude_m, heading, pitch: -30.0, fov: 50.0 }
    }

    #[test]
    fn the_path_passes_through_its_keyframes() {
        let keys = [key(0.0, 170.0, 1e7, 10.0), key(2.0, -170.0, 1e4, 350.0), key(7.0, -160.0, 50.0, 180.0)];
        let path = CameraPath::new(&keys).unwrap();
        for k in &keys {
            let found = path.at(k.time_s);
            assert!((found.altitude_m / k.altitude_m - 1.0).abs() < 1e-9, "{found:?}");
            assert!(short_way(found.longitude - k.longitude).abs() < 1e-9 && short_way(found.heading - k.heading).abs() < 1e-9);
        }
    }

    #[test]
    fn angles_go_the_short_way_and_altitudes_geometrically() {
        let path = CameraPath::new(&[key(0.0, 170.0, 1e6, 10.0), key(2.0, -170.0, 1e2, 350.0)]).unwrap();
        let middle = path.at(1.0);
        assert!((middle.longitude.abs() - 180.0).abs() < 1e-9 && middle.heading.abs() < 1e-9, "{middle:?}");
        assert!((middle.altitude_m - 1e4).abs() < 1e-6);
    }

    #[test]
    fn altitudes_never_leave_the_range_of_their_keyframes() {
        let path = CameraPath::new(&[
            key(0.0, 0.0, 1e7, 0.0),
            key(1.0, 0.0, 60.0, 0.0),
            key(1.5, 0.0, 50.0, 0.0),
            key(4.0, 0.0, 5e3, 0.0),
        ])
        .unwrap();
        for k in 0..=400 {
            let now = path.at(f64::from(k) / 100.0).altitude_m;
            assert!((49.999..=1.0001e7).contains(&now), "{now} at {k}");
        }
    }

    #[test]
    fn bad_keyframes_are_named() {
        assert_eq!(CameraPath::new(&[key(0.0, 0.0, 1.0, 0.0)]).unwrap_err(), PathError::TooFew { found: 1 });
        let order = CameraPath::new(&[key(1.0, 0.0, 1.0, 0.0), key(1.0, 0.0, 1.0, 0.0)]).unwrap_err();
        assert_eq!(order, PathError::Order { number: 1, time_s: 1.0 });
        let value = CameraPath::new(&[key(0.0, 0.0, 1.0, 0.0), key(1.0, 0.0, 0.0, 0.0)]).unwrap_err();
        assert!(value.to_string().starts_with("keyframe 1: altitude_m is 0,"), "{value}");
        assert!(CameraPath::new(&[key(0.0, f64::NAN, 1.0, 0.0), key(1.0, 0.0, 1.0, 0.0)]).is_err());
    }
}
