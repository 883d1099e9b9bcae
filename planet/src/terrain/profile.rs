//! A smooth monotone curve through given points: cubic Hermite pieces with Fritsch-Carlson (1980) slopes, by the
//! harmonic-mean rule of Fritsch and Butland (1984). In: rising pairs. Out: values that never overshoot them.

/// A monotone curve, level beyond its ends.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pieces: Vec<Piece>,
    start: f64,
}

#[derive(Clone, Debug)]
struct Piece {
    from: f64,
    width: f64,
    rise: f64,
    /// Slopes at both ends, times the width.
    slopes: [f64; 2],
}

impl Profile {
    /// From `[x, y]` pairs, x rising, y never falling.
    pub(crate) fn new(pairs: &[[f64; 2]]) -> Self {
        let secants: Vec<f64> = pairs.windows(2).map(|w| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0])).collect();
        let slope = |i: usize| match (i.checked_sub(1).and_then(|j| secants.get(j)), secants.get(i)) {
            (Some(&a), Some(&b)) if a > 0.0 && b > 0.0 => 2.0 * a * b / (a + b),
            _ => 0.0,
        };
        let piece = |(i, w): (usize, &[[f64; 2]])| {
            let width = w[1][0] - w[0][0];
            Piece { from: w[0][0], width, rise: w[1][1] - w[0][1], slopes: [slope(i) * width, slope(i + 1) * width] }
        };
        Self { pieces: pairs.windows(2).enumerate().map(piece).collect(), start: pairs[0][1] }
    }

    /// The curve at `x`: the sum of what each piece has risen by then, so that there is nothing to search.
    pub(crate) fn at(&self, x: f64) -> f64 {
        self.pieces.iter().fold(self.start, |y, p| {
            let t = ((x - p.from) / p.width).clamp(0.0, 1.0);
            let (t2, t3) = (t * t, t * t * t);
            let risen = (3.0 * t2 - 2.0 * t3) * p.rise;
            y + risen + (t3 - 2.0 * t2 + t) * p.slopes[0] + (t3 - t2) * p.slopes[1]
        })
    }

    /// Lowest and highest value.
    pub(crate) fn range(&self) -> (f64, f64) {
        (self.start, self.pieces.iter().fold(self.start, |y, p| y + p.rise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_overshoots_or_misses_its_points() {
        let pairs = [[-1.0, -4000.0], [-0.2, -3900.0], [-0.1, -100.0], [0.0, 0.0], [0.5, 0.0], [1.0, 900.0]];
        let profile = Profile::new(&pairs);
        for [x, y] in pairs {
            assert!((profile.at(x) - y).abs() < 1e-9, "{x}");
        }
        let values: Vec<f64> = (-120..=120).map(|i| profile.at(f64::from(i) * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1] + 1e-9));
        assert_eq!(profile.range(), (-4000.0, 900.0));
    }
}
