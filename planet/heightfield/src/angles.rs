//! Angles without the platform's trigonometry, whose last bits differ between machines: only + - * / and sqrt. Errors are
//! below 1e-14 radians.

use std::f64::consts::{FRAC_PI_2, PI};

/// Sum of x^(2k+1) / (2k+1) with alternating signs, for |x| below 0.2.
fn atan_small(x: f64) -> f64 {
    let x2 = x * x;
    (0..=11).rev().fold(0.0, |sum, k: i32| 1.0 / f64::from(2 * k + 1) - x2 * sum) * x
}

/// Arc tangent, by halving the angle twice.
fn atan_unit(x: f64) -> f64 {
    let halve = |t: f64| t / (1.0 + (1.0 + t * t).sqrt());
    4.0 * atan_small(halve(halve(x)))
}

/// Angle of (x, y) from +x, in radians from -pi to pi; 0 for the origin.
pub fn atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    if ax == 0.0 && ay == 0.0 {
        return 0.0;
    }
    let first = if ay <= ax { atan_unit(ay / ax) } else { FRAC_PI_2 - atan_unit(ax / ay) };
    let half = if x < 0.0 { PI - first } else { first };
    if y < 0.0 {
        -half
    } else {
        half
    }
}

/// Sine and cosine of an angle in degrees (any finite angle below 1e6).
pub fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarter = (degrees / 90.0 + 0.5).floor();
    let x = (degrees - quarter * 90.0) * (PI / 180.0);
    let x2 = x * x;
    // Taylor to x^19 and x^18: below 1e-17 at 45 degrees.
    let sine = (1..=9).rev().fold(1.0, |s, k: i32| 1.0 - s * x2 / f64::from(2 * k * (2 * k + 1))) * x;
    let cosine = (1..=9).rev().fold(1.0, |s, k: i32| 1.0 - s * x2 / f64::from(2 * k * (2 * k - 1)));
    match (quarter as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_match_the_platforms_trigonometry() {
        for i in -720..=720 {
            let degrees = f64::from(i) * 0.77;
            let (s, c) = sin_cos(degrees);
            let exact = degrees.to_radians();
            assert!((s - exact.sin()).abs() < 1e-14 && (c - exact.cos()).abs() < 1e-14, "{degrees}");
            assert!((atan2(s, c) - s.atan2(c)).abs() < 1e-14, "{degrees}");
        }
        for (y, x) in [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)] {
            assert!((atan2(y, x) - f64::atan2(y, x)).abs() < 1e-14);
        }
    }
}
