//! A smooth monotone curve through given points: cubic Hermite pieces with Fritsch-Carlson (1980) slopes, by the
//! harmonic-mean rule of Fritsch and Butland (1984). In: rising pairs. Out: values that never overshoot them.

use super::points::{Lane, LANES};

/// A monotone curve, level beyond its ends.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pieces: Vec<Piece>,
    start: f64,
}

/// Between two points: y risen since the first, as a cubic of the share of the way.
#[derive(Clone, Debug)]
struct Piece {
    from: f32,
    per_width: f32,
    /// Coefficients of the first, second and third power.
    powers: [f32; 3],
    rise: f64,
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
            let (width, rise) = (w[1][0] - w[0][0], w[1][1] - w[0][1]);
            let [first, last] = [slope(i) * width, slope(i + 1) * width];
            let powers = [first, 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise].map(|c| c as f32);
            Piece { from: w[0][0] as f32, per_width: (1.0 / width) as f32, powers, rise }
        };
        Self { pieces: pairs.windows(2).enumerate().map(piece).collect(), start: pairs[0][1] }
    }

    /// The curve at every lane: the sum of what each piece has risen by then, so that there is nothing to search.
    #[inline(always)]
    pub(crate) fn lanes(&self, x: &Lane) -> Lane {
        let mut y = [self.start as f32; LANES];
        for p in &self.pieces {
            for i in 0..LANES {
                let t = ((x[i] - p.from) * p.per_width).clamp(0.0, 1.0);
                y[i] += t * (p.powers[0] + t * (p.powers[1] + t * p.powers[2]));
            }
        }
        y
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
    fn the_curve_passes_its_points_without_overshoot() {
        let pairs = [[-1.0, -4000.0], [-0.2, -3900.0], [-0.1, -100.0], [0.0, 0.0], [0.5, 0.0], [1.0, 900.0]];
        let profile = Profile::new(&pairs);
        let at = |x: f64| profile.lanes(&[x as f32; LANES])[0];
        for [x, y] in pairs {
            assert!((at(x) - y as f32).abs() < 2e-3, "{x}");
        }
        let values: Vec<f32> = (-120..=120).map(|i| at(f64::from(i) * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1] + 2e-3));
        assert_eq!(profile.range(), (-4000.0, 900.0));
    }
}
