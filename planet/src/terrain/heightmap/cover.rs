//! How much a heightmap counts near samples without data: nothing at them, fully some samples away.
//!
//! In: the samples. Out: a weight for any position between them. Distances go by chamfer steps (Borgefors 1986).

use super::smoothstep;
use std::f64::consts::SQRT_2;
use terrane_heightfield::Heightfield;

/// Samples over which the map fades in around a gap.
const FADE: f64 = 6.0;

/// Weights from 0 to 1, one a sample.
pub(super) struct Cover {
    columns: usize,
    rows: usize,
    weights: Vec<f32>,
}

impl Cover {
    /// Nothing for a field without gaps.
    pub(super) fn new(field: &Heightfield) -> Option<Cover> {
        let (columns, rows) = (field.columns(), field.rows());
        let gap = |h: &f32| if h.is_nan() { 0.0 } else { FADE as f32 };
        let mut weights: Vec<f32> = field.heights().iter().map(gap).collect();
        if weights.iter().all(|&w| w > 0.0) {
            return None;
        }
        spread(&mut weights, columns, [(-1, 0), (-1, -1), (0, -1), (1, -1)], false);
        spread(&mut weights, columns, [(1, 0), (1, 1), (0, 1), (-1, 1)], true);
        weights.iter_mut().for_each(|w| *w = smoothstep([0.0, FADE], f64::from(*w)) as f32);
        Some(Cover { columns, rows, weights })
    }

    /// Weight at a position between samples (bilinear); 0 next to a gap.
    pub(super) fn at(&self, column: f64, row: f64, wraps: bool) -> f64 {
        let (c, r) = (column.floor(), row.floor());
        let (across, down) = (column - c, row - r);
        let at = |i: i64, j: i64| self.weight(c as i64 + i, r as i64 + j, wraps);
        let line = |j: i64| at(0, j) + (at(1, j) - at(0, j)) * across;
        let (above, below) = (line(0), line(1));
        above + (below - above) * down
    }

    /// Mean weight of a row.
    pub(super) fn row_mean(&self, row: usize) -> f64 {
        let weights = &self.weights[row * self.columns..][..self.columns];
        weights.iter().map(|&w| f64::from(w)).sum::<f64>() / self.columns as f64
    }

    fn weight(&self, column: i64, row: i64, wraps: bool) -> f64 {
        let columns = self.columns as i64;
        let column = if wraps { column.rem_euclid(columns) } else { column.clamp(0, columns - 1) };
        f64::from(self.weights[(row.clamp(0, self.rows as i64 - 1) * columns + column) as usize])
    }
}

/// One pass over all samples, forwards or backwards: each is at most a step farther from a gap than the neighbours that the
/// pass has been at.
fn spread(distances: &mut [f32], columns: usize, neighbours: [(i64, i64); 4], backwards: bool) {
    let rows = distances.len() / columns;
    for k in 0..distances.len() {
        let sample = if backwards { distances.len() - 1 - k } else { k };
        let (column, row) = ((sample % columns) as i64, (sample / columns) as i64);
        for (i, j) in neighbours {
            let (c, r) = (column + i, row + j);
            if (0..columns as i64).contains(&c) && (0..rows as i64).contains(&r) {
                let step = if i != 0 && j != 0 { SQRT_2 as f32 } else { 1.0 };
                let through = distances[r as usize * columns + c as usize] + step;
                distances[sample] = distances[sample].min(through);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_fade_evenly() {
        let mut heights = vec![1.0; 21 * 21];
        assert!(Cover::new(&Heightfield::new(21, 21, heights.clone()).unwrap()).is_none());
        heights[10 * 21 + 10] = f32::NAN;
        let cover = Cover::new(&Heightfield::new(21, 21, heights).unwrap()).unwrap();
        assert_eq!((cover.at(10.0, 10.0, false), cover.at(17.0, 10.0, false), cover.at(0.0, 0.0, true)), (0.0, 1.0, 1.0));
        for (i, j) in [(1.0, 0.0), (3.0, 0.0), (2.0, 2.0), (4.5, 1.5)] {
            let four = [(i, j), (-i, j), (i, -j), (-j, i)].map(|(i, j)| cover.at(10.0 + i, 10.0 + j, false));
            assert!(four.iter().all(|w| (w - four[0]).abs() < 1e-6) && (0.0..1.0).contains(&four[0]), "{four:?}");
        }
        let outwards: Vec<f64> = (0..30).map(|k| cover.at(10.0 + f64::from(k) * 0.25, 10.0, false)).collect();
        assert!(outwards.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] < 0.08), "{outwards:?}");
    }
}
