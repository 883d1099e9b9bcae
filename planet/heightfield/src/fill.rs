//! Fills samples without data from those around them: averages over ever coarser grids ("pull"), then bilinear values back
//! into the gaps only ("push"). (Pull-push: Gortler and others, The Lumigraph, 1996.)
//!
//! Deterministic: sums in a fixed order, only + - * /.

use crate::Heightfield;

/// One level of the pyramid; NaN where nothing is known yet.
struct Level {
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl Heightfield {
    /// Gives every sample without data a height from its surroundings; the others stay as they are. Out: how many were
    /// filled. A field without any data is left alone.
    pub fn fill_gaps(&mut self) -> usize {
        let gaps = self.heights.iter().filter(|h| h.is_nan()).count();
        if gaps == 0 || gaps == self.heights.len() {
            return 0;
        }
        let mut finest = Level { columns: self.columns, rows: self.rows, values: std::mem::take(&mut self.heights) };
        finest.fill();
        self.heights = finest.values;
        gaps
    }
}

impl Level {
    fn fill(&mut self) {
        if !self.values.iter().any(|v| v.is_nan()) {
            return;
        }
        let mut coarse = self.halved();
        coarse.fill();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let value = &mut self.values[row * self.columns + column];
                if value.is_nan() {
                    *value = coarse.between(column, row);
                }
            }
        }
    }

    /// Means of what is known in squares of 2 × 2.
    fn halved(&self) -> Level {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let mean = |(column, row): (usize, usize)| {
            let square = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (2 * column + i, 2 * row + j));
            let inside = square.iter().filter(|(i, j)| *i < self.columns && *j < self.rows);
            let known = inside.map(|(i, j)| f64::from(self.values[j * self.columns + i])).filter(|v| !v.is_nan());
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
            // 0 / 0 is NaN: still unknown.
            (sum / count) as f32
        };
        let values = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).map(mean).collect();
        Level { columns, rows, values }
    }

    /// Bilinear value at a sample of the level that is twice as fine.
    fn between(&self, column: usize, row: usize) -> f32 {
        // The sample lies a quarter of a cell from the centre of the cell that holds it.
        let beside =
            |k: usize, most: usize| if k.is_multiple_of(2) { (k / 2).saturating_sub(1) } else { (k / 2 + 1).min(most - 1) };
        let (c, r) = (column / 2, row / 2);
        let (c2, r2) = (beside(column, self.columns), beside(row, self.rows));
        let at = |c: usize, r: usize| f64::from(self.values[r * self.columns + c]);
        ((9.0 * at(c, r) + 3.0 * (at(c2, r) + at(c, r2)) + at(c2, r2)) / 16.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_from_their_surroundings() {
        let plane = |i: usize| (i % 37) as f32 * 2.0 + (i / 37) as f32;
        let whole = Heightfield::new(37, 23, (0..37 * 23).map(plane).collect()).unwrap();
        let mut holed = whole.clone();
        let hole = |i: usize| (12..17).contains(&(i % 37)) && (9..14).contains(&(i / 37)) || i == 0;
        (0..37 * 23).filter(|&i| hole(i)).for_each(|i| holed.heights[i] = f32::NAN);
        assert_eq!(holed.fill_gaps(), 26);
        for i in 0..37 * 23 {
            let off = (holed.heights[i] - whole.heights[i]).abs();
            assert!(if hole(i) { off < 4.0 } else { off == 0.0 }, "sample {i} is off by {off}");
        }
        assert_eq!(holed.fill_gaps(), 0);
    }

    #[test]
    fn one_known_sample_fills_all_and_none_fills_nothing() {
        let mut heights = vec![f32::NAN; 35];
        let mut nothing = Heightfield::new(7, 5, heights.clone()).unwrap();
        assert_eq!((nothing.fill_gaps(), nothing.heights.len()), (0, 35));
        heights[17] = -3.0;
        let mut field = Heightfield::new(7, 5, heights).unwrap();
        assert_eq!(field.fill_gaps(), 34);
        assert!(field.heights.iter().all(|&h| h == -3.0));
    }
}
