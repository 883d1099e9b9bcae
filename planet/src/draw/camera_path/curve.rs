//! Smooth curves through numbers that never overshoot: cubic Hermite curves with the tangents of Fritsch and Carlson (1980). In: knots
//! and values. Out: values in between.

/// How a curve leaves its first value and reaches its last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// From rest and to rest.
    Soft,
    /// As steep as it goes on, and as it came.
    Running,
}

/// A place between two knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// Number of the knot before.
    pub(super) from: usize,
    /// Share of the way to the next, 0 to 1.
    pub(super) share: f64,
    /// From one to the other.
    pub(super) step: f64,
}

impl Between {
    /// Where among at least two rising knots a number lies; those outside are at the ends.
    pub(super) fn of(knots: &[f64], at: f64) -> Between {
        let at = at.clamp(knots[0], knots[knots.len() - 1]);
        let after = knots.partition_point(|&knot| knot <= at).clamp(1, knots.len() - 1);
        let (from, step) = (after - 1, knots[after] - knots[after - 1]);
        Between { from, share: (at - knots[from]) / step, step }
    }
}

/// A curve over knots that its owner keeps.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    values: Vec<f64>,
    tangents: Vec<f64>,
}

impl Curve {
    /// The curve through as many values as there are knots, at least two.
    pub(super) fn new(knots: &[f64], values: Vec<f64>, ends: Ends) -> Curve {
        let slope = |k: usize| (values[k + 1] - values[k]) / (knots[k + 1] - knots[k]);
        let last = values.len() - 1;
        let tangent = |k: usize| match ends {
            Ends::Soft if k == 0 || k == last => 0.0,
            Ends::Running if k == 0 => slope(0),
            Ends::Running if k == last => slope(last - 1),
            _ => {
                let (before, after) = (slope(k - 1), slope(k));
                let steps = [knots[k] - knots[k - 1], knots[k + 1] - knots[k]];
                before.signum() * if before * after <= 0.0 { 0.0 } else { speed_between([before.abs(), after.abs()], steps) }
            }
        };
        let tangents = (0..=last).map(tangent).collect();
        Curve { values, tangents }
    }

    /// Its value, within those of the knots around.
    pub(super) fn at(&self, place: Between) -> f64 {
        let Between { from, share: s, step } = place;
        let [a, b] = [self.values[from], self.values[from + 1]];
        let [u, v] = [self.tangents[from] * step, self.tangents[from + 1] * step];
        let cubic = a + (b - a) * s * s * (3.0 - 2.0 * s) + (u * (1.0 - s) - v * s) * s * (1.0 - s);
        cubic.clamp(a.min(b), a.max(b))
    }

    /// Its value at a knot.
    pub(super) fn knot(&self, k: usize) -> f64 {
        self.values[k]
    }
}

/// The speed at a knot, of the mean speeds before and after it and their durations: a weighted harmonic mean, 0 if one of them is, and never
/// more than three times the slower.
pub(super) fn speed_between([before, after]: [f64; 2], [left, right]: [f64; 2]) -> f64 {
    if before <= 0.0 || after <= 0.0 {
        return 0.0;
    }
    let (a, b) = (2.0 * right + left, right + 2.0 * left);
    (a + b) / (a / before + b / after)
}
