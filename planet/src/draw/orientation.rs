//! The orientation term of selection (Hoppe 1997): an error is radial, and one that is seen end-on moves few pixels.
//!
//! In: where the eye is, and how steep the selection distance may become. Out: a distance that takes the place of that to the
//! eye. With p from the eye to a point x, an error e at x subtends e sin(p, x) / |p|, so any distance up to |p| / sin(p, x) keeps
//! the certificate. Closure asks for more: it must change by at most `slope` a unit of way. The larger of |p| and
//! height · h − side · r, with h how far x lies below the eye along the eye's own vertical and r how far aside, does both. Its second part is linear in h and r, so its slope is √(height² + side²) everywhere. On a flat ground, where
//! sin(p, x) = r / |p|, it stays below (h² + r²) / r if height² ≤ 4 (1 + side). On a planet the vertical at x leans away from the
//! eye's by an angle θ, and sin(p, x) ≤ (r + h sin θ) / |p|; then `height` must be 2 √((1 + side)(1 + ε²)) − (2 + side) ε, where ε
//! is the largest sin θ of the points for which the second part is the larger one. From far up nothing is left of it.

use crate::globe::lattice::LatticeBox;
use glam::DVec3;

/// The term for one eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// The eye's vertical, a unit vector.
    pub up: DVec3,
    /// Weight of the height of the eye over a point.
    pub height: f64,
    /// Weight of how far aside a point lies.
    pub side: f64,
}

impl Orientation {
    /// The term for an eye over ground no lower than `ground` from the planet's centre, with a slope of at most `slope`. `None` where it
    /// would change nothing: for slopes up to 1, and from far up.
    pub fn new(eye: DVec3, ground: f64, slope: f64) -> Option<Orientation> {
        if slope <= 1.0 {
            return None;
        }
        let side = slope - 2.0;
        let lean = largest_lean(eye.length() / ground - 1.0, 2.0 / (1.0 + side).sqrt());
        let height = 2.0 * ((1.0 + side) * (1.0 + lean * lean)).sqrt() - (2.0 + side) * lean;
        let term = Orientation { up: eye.try_normalize()?, height, side };
        let farthest = if side < 0.0 { height.hypot(side) } else { height };
        (height > 0.0 && farthest > 1.0).then_some(term)
    }

    /// How much the distance changes a unit of way, at most.
    pub fn slope(&self) -> f64 {
        self.height.hypot(self.side).max(1.0)
    }

    /// The distance of a point, given from the eye.
    pub fn distance(&self, point: DVec3) -> f64 {
        let below = -point.dot(self.up);
        let aside = point.cross(self.up).length();
        point.length().max(self.height * below - self.side * aside)
    }

    /// A lower bound of `height · h − side · r` over a box, given from the eye: both parts are at their least at a corner (if `side` is
    /// negative, r is left out).
    pub fn least(&self, bounds: &LatticeBox, eye: DVec3) -> f64 {
        let (low, high) = (bounds.low.as_dvec3() - eye, bounds.high.as_dvec3() - eye);
        let at = |corner: usize| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let point = DVec3::new(pick(0), pick(1), pick(2));
            -self.height * point.dot(self.up) - self.side.max(0.0) * point.cross(self.up).length()
        };
        (0..8).map(at).fold(f64::INFINITY, f64::min)
    }
}

/// The largest sine of the angle at the planet's centre between the eye and a point in sight, `height` planet radii below the
/// eye, whose direction leans from the eye's vertical by a tangent of at most `steepest`.
fn largest_lean(height: f64, steepest: f64) -> f64 {
    if height <= 0.0 {
        return 0.0;
    }
    // With T = tan(θ / 2), a line of tangent t from the eye meets the sphere where (2 t + q) T² − 2 T + q = 0, q = t · height.
    let q = steepest * height;
    let discriminant = 1.0 - q * (2.0 * steepest + q);
    if discriminant <= 0.0 {
        // It passes the sphere: the horizon leans most.
        let cosine = 1.0 / (1.0 + height);
        return (1.0 - cosine * cosine).sqrt();
    }
    let half = (1.0 - discriminant.sqrt()) / (2.0 * steepest + q);
    2.0 * half / (1.0 + half * half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RADIUS: f64 = 6.371e6;

    /// A direction from two numbers within 0 and 1.
    fn direction((a, b): (f64, f64)) -> DVec3 {
        let (z, turn) = (2.0 * a - 1.0, std::f64::consts::TAU * b);
        let around = (1.0 - z * z).sqrt();
        DVec3::new(around * turn.cos(), around * turn.sin(), z)
    }

    fn unit_pair() -> impl Strategy<Value = (f64, f64)> {
        (0.0..1.0f64, 0.0..1.0f64)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn errors_in_sight_subtend_no_more_than_the_distance_allows(
            log_height in 1.0..16.5f64, hill in 0.0..8000.0f64, slope in 1.05..4.0f64,
            ahead in 0.0..1.0f64, turn in 0.0..1.0f64,
        ) {
            let eye = DVec3::X * (RADIUS + log_height.exp());
            let Some(term) = Orientation::new(eye, RADIUS, slope) else { return Ok(()) };
            // Towards the horizon of the lowest ground, most of the points near the eye.
            let horizon = (RADIUS / eye.x).acos();
            let angle = horizon * ahead.powi(3);
            let radius = RADIUS + hill.min(eye.x - RADIUS);
            let up = DVec3::new(angle.cos(), angle.sin() * (turn * 6.3).cos(), angle.sin() * (turn * 6.3).sin());
            let point = up * radius - eye;
            let aside = point.cross(up).length();
            prop_assert!(term.distance(point) * aside <= point.length_squared() * (1.0 + 1e-9), "{term:?}");
        }

        #[test]
        fn the_distance_is_as_steep_as_it_says(
            log_height in 1.0..16.5f64, slope in 1.05..4.0f64, at in unit_pair(), to in unit_pair(), far in 0.0..17.0f64, step in 0.0..16.0f64,
        ) {
            let eye = direction((0.3, 0.7)) * (RADIUS + log_height.exp());
            let Some(term) = Orientation::new(eye, RADIUS, slope) else { return Ok(()) };
            prop_assert!(term.slope() <= slope * (1.0 + 1e-12), "{term:?}");
            let (a, way) = (direction(at) * far.exp(), direction(to) * step.exp());
            let change = (term.distance(a + way) - term.distance(a)).abs();
            prop_assert!(change <= term.slope() * way.length() + 1e-6, "{change} over {}", way.length());
        }

        #[test]
        fn boxes_are_no_farther_than_what_they_hold(
            slope in 1.05..4.0f64, corner in unit_pair(), far in 0.0..17.0f64, size in 0.0..16.0f64, inside in [0.0..1.0f64, 0.0..1.0, 0.0..1.0],
        ) {
            let eye = direction((0.8, 0.2)) * (RADIUS + 500.0);
            let term = Orientation::new(eye, RADIUS, slope).unwrap();
            let low = (eye + direction(corner) * far.exp()).round();
            let size = DVec3::splat(size.exp()).round();
            let bounds = LatticeBox { low: low.as_ivec3(), high: (low + size).as_ivec3() };
            let point = low + size * DVec3::from_array(inside) - eye;
            prop_assert!(term.least(&bounds, eye) <= term.distance(point) + 1e-6);
        }
    }

    #[test]
    fn a_steeper_term_breaks_the_certificate() {
        let eye = DVec3::X * (RADIUS + 2e4);
        let term = Orientation::new(eye, RADIUS, 2.5).unwrap();
        let steeper = Orientation { height: 1.05 * term.height, ..term };
        let breaks = |term: &Orientation| {
            (1..2000).any(|k| {
                let angle = f64::from(k) * 1e-5;
                let up = DVec3::new(angle.cos(), angle.sin(), 0.0);
                let point = up * RADIUS - eye;
                term.distance(point) * point.cross(up).length() > point.length_squared() * (1.0 + 1e-9)
            })
        };
        assert!(!breaks(&term) && breaks(&steeper));
    }

    #[test]
    fn the_term_counts_near_the_ground_and_vanishes_from_afar() {
        let at = |height_m: f64| Orientation::new(DVec3::Z * (RADIUS + height_m), RADIUS, 2.3);
        let near = at(100.0).unwrap();
        assert!((near.distance(DVec3::NEG_Z * 100.0) / 100.0 - 2.0 * 1.3f64.sqrt()).abs() < 0.02, "{near:?}");
        assert!(at(1e5).unwrap().height < near.height && at(2e7).is_none());
        assert!(Orientation::new(DVec3::Z * (RADIUS + 100.0), RADIUS, 1.0).is_none());
    }
}
