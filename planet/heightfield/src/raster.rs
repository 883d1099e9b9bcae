//! Scan conversion of triangles over the samples of a heightfield. In: three corners in the coordinates of
//! [`crate::Heightfield::position`]. Out: row by row, the two points where the triangle's sides cross the row.
//!
//! Triangles that share an edge compute the same bits for its crossings, so no sample falls between them however vertices lie
//! off the grid, and with half-open spans every sample belongs to exactly one of them.

use crate::Heightfield;
use glam::DVec3;
use std::ops::Range;

/// A side of a triangle, from its southern (or, if level, western) end.
struct Side {
    low: DVec3,
    high: DVec3,
    /// What one row further north adds. Not finite for level sides, which are asked for their ends alone.
    step: DVec3,
}

impl Side {
    fn new(low: DVec3, high: DVec3) -> Side {
        Side { low, high, step: (high - low) / (high.y - low.y) }
    }

    /// Where the side crosses the line at `y`; exactly its end if that lies on the line.
    fn at(&self, y: f64) -> DVec3 {
        if y == self.low.y {
            self.low
        } else if y == self.high.y {
            self.high
        } else {
            self.low + self.step * (y - self.low.y)
        }
    }
}

/// Calls `visit(y, west, east)` for every row of samples, at most `last`, that meets a triangle which has area, from south to north.
pub(super) fn for_each_row(triangle: [DVec3; 3], last: f64, mut visit: impl FnMut(f64, DVec3, DVec3)) {
    let [south, middle, north] = from_south(triangle);
    let (long, lower, upper) = (Side::new(south, north), Side::new(south, middle), Side::new(middle, north));
    let (mut y, end) = (south.y.ceil().max(0.0), north.y.floor().min(last));
    while y <= end {
        let p = long.at(y);
        // A level side is passed at its other end.
        let q = if y == middle.y {
            middle
        } else if y < middle.y {
            lower.at(y)
        } else {
            upper.at(y)
        };
        if p.x <= q.x {
            visit(y, p, q);
        } else {
            visit(y, q, p);
        }
        y += 1.0;
    }
}

/// Calls `visit(y, first, row)` for the samples of `field` that a triangle inside the rectangle owns: `row` are their numbers and
/// `first` is the column of the first. Over a triangulation of the rectangle with its vertices on samples, every sample inside
/// is owned once; those on its eastern and northern sides at least once.
pub(super) fn for_each_owned(triangle: [DVec3; 3], field: &Heightfield, mut visit: impl FnMut(f64, f64, Range<usize>)) {
    let (columns, rows) = (field.columns(), field.rows());
    let [east_end, north_end] = [columns - 1, rows - 1].map(|k| k as f64);
    let top = triangle[0].y.max(triangle[1].y).max(triangle[2].y);
    let last = if top == north_end { top } else { top - 1.0 };
    for_each_row(triangle, last, |y, west, east| {
        let first = west.x.ceil();
        let end = if east.x == east_end { columns } else { east.x.ceil() as usize };
        let start = first as usize;
        if start < end {
            let row = (rows - 1 - y as usize) * columns;
            visit(y, first, row + start..row + end);
        }
    });
}

fn from_south(triangle: [DVec3; 3]) -> [DVec3; 3] {
    let ordered = |p: DVec3, q: DVec3| if (p.y, p.x) <= (q.y, q.x) { (p, q) } else { (q, p) };
    let [a, b, c] = triangle;
    let (a, b) = ordered(a, b);
    let (b, c) = ordered(b, c);
    let (a, b) = ordered(a, b);
    [a, b, c]
}
