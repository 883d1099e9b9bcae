//! Where a straight edge of a simplified mesh crosses the edges of the full grid.
//!
//! The difference of two piecewise linear surfaces is largest at a corner of one of them or where edges of the two cross. Corners
//! are samples; here are the crossings.

use super::samples::Samples;
use super::star::opposite;

impl Samples {
    /// The largest error where the new edges of a collapse into `p`, of its closed ring, cross those of the full grid. `error` is
    /// that of a sample beside the crossing, by its number, between two depths: the grid's and the edge's.
    pub fn error_between(&self, ring: &[u32], p: u32, error: impl Fn(u32, f64, f64) -> f64) -> f64 {
        opposite(ring, p).map(|w| self.edge_error(p, w, &error)).fold(0.0, f64::max)
    }

    /// The same of one edge from sample `p` to `w`.
    pub fn edge_error(&self, p: u32, w: u32, error: impl Fn(u32, f64, f64) -> f64) -> f64 {
        let mut worst = 0.0f64;
        self.crossings(p, w, |near, own, depth| worst = worst.max(error(near, own, depth)));
        worst
    }

    /// Calls `visit` with every point where the edge from sample `p` to `w` crosses an edge of the full grid: a sample beside it,
    /// the grid's depth and the edge's. Walks from cell to cell (Amanatides and Woo 1987).
    fn crossings(&self, p: u32, w: u32, mut visit: impl FnMut(u32, f64, f64)) {
        let (start, end) = (self.at(p), self.at(w));
        let ([c0, r0], [c1, r1]) = (self.column_and_row(p), self.column_and_row(w));
        if c0 == c1 || r0 == r1 {
            return;
        }
        let (dx, dy, dq) = (end.x - start.x, end.y - start.y, end.q - start.q);
        let (per_x, per_y) = (1.0 / dx, 1.0 / dy);
        let (right, up) = (usize::from(c1 > c0), usize::from(r1 > r0));
        let (mut c, mut r) = (c0 + right - 1, r0 + up - 1);
        let last = (c1 - right, r1 - up);
        let mut entered = 0.0;
        loop {
            let tx = (self.column(c + right) - start.x) * per_x;
            let ty = (self.row(r + up) - start.y) * per_y;
            let is_last = (c, r) == last;
            let left = if is_last { 1.0 } else { tx.min(ty) };
            let odd = (c + r) % 2;
            let (a, b) = (self.number(c + odd, r), self.number(c + 1 - odd, r + 1));
            let (low, high) = (self.at(a), self.at(b));
            let (bx, by) = (high.x - low.x, high.y - low.y);
            let t = (by * (start.x - low.x) - bx * (start.y - low.y)) / (bx * dy - by * dx);
            if entered < t && t < left {
                visit(a, low.q + (high.q - low.q) * ((start.x + t * dx - low.x) / bx), start.q + t * dq);
            }
            if is_last {
                return;
            }
            if r == last.1 || (c != last.0 && tx < ty) {
                let (a, b) = (self.number(c + right, r), self.number(c + right, r + 1));
                let share = (start.y + tx * dy - self.row(r)) / (self.row(r + 1) - self.row(r));
                visit(a, self.depth(a) + (self.depth(b) - self.depth(a)) * share, start.q + tx * dq);
                (c, entered) = (c + 2 * right - 1, tx);
            } else {
                let (a, b) = (self.number(c, r + up), self.number(c + 1, r + up));
                let share = (start.x + ty * dx - self.column(c)) / (self.column(c + 1) - self.column(c));
                visit(a, self.depth(a) + (self.depth(b) - self.depth(a)) * share, start.q + ty * dq);
                (r, entered) = (r + 2 * up - 1, ty);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Crossings of an edge over a 9 × 9 grid whose depth is a function.
    fn found(p: [usize; 2], w: [usize; 2], depth: impl Fn(f64, f64) -> f64) -> Vec<(f64, f64)> {
        let line: Vec<f64> = (0..9).map(f64::from).collect();
        let points = (0..81).map(|k| (f64::from(k % 9), f64::from(k / 9)));
        let samples = Samples::new(line.clone(), line, points.map(|(x, y)| depth(x, y)));
        let mut all = Vec::new();
        samples.crossings(samples.number(p[0], p[1]), samples.number(w[0], w[1]), |_, own, edge| all.push((own, edge)));
        all
    }

    #[test]
    fn a_saddle_between_samples_is_found() {
        // Depth x y over one cell. The grid splits the cell along its rising diagonal, whose middle has depth 0.5; the edge is the falling
        // diagonal, whose middle has depth 0.
        let crossings = found([1, 0], [0, 1], |x, y| x * y);
        assert_eq!(crossings, [(0.5, 0.0)]);
    }

    #[test]
    fn all_crossings_are_found_and_lie_on_the_edge() {
        for (p, w) in [([0usize, 0], [5usize, 3]), ([8, 1], [2, 7]), ([3, 8], [4, 0]), ([7, 7], [1, 4]), ([6, 2], [0, 8])] {
            let [columns, rows] = [0, 1].map(|axis: usize| p[axis].abs_diff(w[axis]));
            let all = found(p, w, |x, y| 2.0 * x - 3.0 * y);
            assert!(all.iter().all(|(own, edge)| (own - edge).abs() < 1e-12), "a plane has no error: {all:?}");
            // The grid lines between both ends, and about as many diagonals.
            assert!(all.len() >= columns + rows - 2 && all.len() <= 2 * (columns + rows), "{p:?} {w:?}: {}", all.len());
        }
        assert_eq!(found([2, 3], [7, 3], |x, y| x * y).len(), 0, "along a row nothing is crossed");
    }
}
