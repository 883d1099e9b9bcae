//! Heightfields and the surfaces over them.

use glam::DVec3;

/// A rectangle of heights, row by row, row 0 north and column 0 west, as images and elevation models store them.
#[derive(Clone, Debug, PartialEq)]
pub struct Heightfield {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) heights: Vec<f32>,
}

impl Heightfield {
    /// A heightfield from its samples, row by row from the north; `None` unless there are `columns` × `rows` of them and at
    /// least 2 × 2. Samples without data are NaN.
    pub fn new(columns: usize, rows: usize, heights: Vec<f32>) -> Option<Heightfield> {
        let fits = columns >= 2 && rows >= 2 && columns.checked_mul(rows) == Some(heights.len());
        fits.then_some(Heightfield { columns, rows, heights })
    }

    /// Samples from west to east.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Samples from north to south.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// All heights, row by row from the north; NaN where there is no data.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// The heights alone.
    pub fn into_heights(self) -> Vec<f32> {
        self.heights
    }

    /// Height of a sample.
    ///
    /// # Panics
    /// Outside the field.
    pub fn at(&self, column: usize, row: usize) -> f32 {
        assert!(column < self.columns);
        self.heights[row * self.columns + column]
    }

    /// Position of sample number `row * columns + column`: x east and y north of the south-west corner in units of one sample
    /// spacing, z up in the unit of the heights.
    pub fn position(&self, sample: usize) -> DVec3 {
        let (column, row) = (sample % self.columns, sample / self.columns);
        DVec3::new(column as f64, (self.rows - 1 - row) as f64, f64::from(self.heights[sample]))
    }
}

/// A triangle surface over a heightfield, in its coordinates (see [`Heightfield::position`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSurface {
    /// Vertices: x and y in sample spacings, z in the unit of the heights.
    pub positions: Vec<DVec3>,
    /// Corners of the triangles, counter-clockwise seen from above.
    pub faces: Vec<[u32; 3]>,
}
