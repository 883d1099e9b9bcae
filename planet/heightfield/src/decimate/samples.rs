//! The samples that a mesh approximates, as a simplifier sees them: a plane with straight rows and columns, and over every grid
//! point a depth that is affine on every triangle.
//!
//! On a plain heightfield that is the height itself. On a planet it is the gnomonic plane, see `surface.rs` of terrane-planet.

use super::mesh::NONE;

/// One sample in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Column, in cells.
    pub x: f64,
    /// Row, in cells.
    pub y: f64,
    /// Depth: affine on every triangle.
    pub q: f64,
}

/// Doubled signed area of a, b, c in cells.
#[inline(always)]
pub fn area(a: &Sample, b: &Sample, c: &Sample) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// A stored sample: 16 bytes, so that one access brings everything. Its x and y are looked up by column and row.
#[derive(Clone, Copy, Debug)]
struct Stored {
    q: f64,
    column: u16,
    row: u16,
    /// The next removed sample below the same triangle.
    next: u32,
}

/// All samples of a grid; number `row * columns + column`.
#[derive(Clone)]
pub struct Samples {
    columns: Vec<f64>,
    rows: Vec<f64>,
    stored: Vec<Stored>,
}

/// Most samples a side.
pub const MOST_SAMPLES_A_SIDE: usize = 1 << 16;

impl Samples {
    /// A grid with the given positions of columns and rows (rising, at most [`MOST_SAMPLES_A_SIDE`] each) and depths, row by row.
    pub fn new(columns: Vec<f64>, rows: Vec<f64>, depths: impl Iterator<Item = f64>) -> Samples {
        let grid = (0..rows.len()).flat_map(|row| (0..columns.len()).map(move |column| (column, row)));
        let stored = |((column, row), q)| Stored { q, column: column as u16, row: row as u16, next: NONE };
        let stored = grid.zip(depths).map(stored).collect();
        Samples { columns, rows, stored }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.stored.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.stored.is_empty()
    }

    /// Column and row of a sample.
    #[inline(always)]
    pub fn column_and_row(&self, s: u32) -> [usize; 2] {
        let stored = &self.stored[s as usize];
        [usize::from(stored.column), usize::from(stored.row)]
    }

    /// Number of the sample in a column and row.
    #[inline(always)]
    pub fn number(&self, column: usize, row: usize) -> u32 {
        (row * self.columns.len() + column) as u32
    }

    /// Position of a column.
    #[inline(always)]
    pub fn column(&self, column: usize) -> f64 {
        self.columns[column]
    }

    /// Position of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> f64 {
        self.rows[row]
    }

    /// Depth of a sample.
    #[inline(always)]
    pub fn depth(&self, s: u32) -> f64 {
        self.stored[s as usize].q
    }

    /// A sample by its number.
    #[inline(always)]
    pub fn at(&self, s: u32) -> Sample {
        self.at_and_next(s).0
    }

    /// A sample, and the one after it in the list of its triangle.
    #[inline(always)]
    pub fn at_and_next(&self, s: u32) -> (Sample, u32) {
        let stored = &self.stored[s as usize];
        let (x, y) = (self.columns[usize::from(stored.column)], self.rows[usize::from(stored.row)]);
        (Sample { x, y, q: stored.q }, stored.next)
    }

    /// The sample after `s` in the list of its triangle.
    #[inline(always)]
    pub fn next(&self, s: u32) -> u32 {
        self.stored[s as usize].next
    }

    /// Makes `next` follow `s` in its list.
    #[inline(always)]
    pub fn set_next(&mut self, s: u32, next: u32) {
        self.stored[s as usize].next = next;
    }
}
