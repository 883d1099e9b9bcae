//! Numbers on the samples of a map, smooth between them: quadratic B-splines, which stay within the samples and never ring. In: a position
//! in columns and rows. Out: a number.

/// One number a sample, row by row.
pub(super) struct Grid {
    pub(super) size: [usize; 2],
    pub(super) values: Vec<f32>,
    /// Whether the last column's neighbour is the first.
    pub(super) wraps: bool,
}

/// The nearest sample of a position and the weights of those before, at and after it.
#[inline(always)]
pub(super) fn spline_weights(at: f64) -> (i64, [f32; 3]) {
    let middle = (at + 0.5).floor();
    let t = (at - middle) as f32;
    (middle as i64, [0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)])
}

impl Grid {
    /// The sample of a column and a row, which may lie beyond the edges.
    #[inline(always)]
    pub(super) fn value(&self, column: i64, row: i64) -> f32 {
        let [columns, rows] = self.size.map(|side| side as i64);
        let column = if self.wraps { column.rem_euclid(columns) } else { column.clamp(0, columns - 1) };
        self.values[(row.clamp(0, rows - 1) * columns + column) as usize]
    }

    /// The number between samples.
    pub(super) fn at(&self, column: f64, row: f64) -> f32 {
        let ((c, across), (r, down)) = (spline_weights(column), spline_weights(row));
        let mut sum = 0.0;
        for (j, wj) in down.iter().enumerate() {
            for (i, wi) in across.iter().enumerate() {
                sum += wi * wj * self.value(c + i as i64 - 1, r + j as i64 - 1);
            }
        }
        sum
    }
}
