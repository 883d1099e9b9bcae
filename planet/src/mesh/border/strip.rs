//! The strip of cells between a border line and the row of samples beside it, seen from the planet's centre.
//!
//! A border vertex that falls along its line spans new edges from its target to the row beside the line. Between samples those are
//! off the ground too, where they cross the edges of the full grid. In: the samples of line and row. Out: the largest such error.

use crate::ground::SurfacePoint;
use multiversion::multiversion;
use std::ops::RangeInclusive;

/// Line and row in the gnomonic plane of the face that holds both: straight and parallel there, with a depth that is affine on
/// every triangle.
pub(super) struct Strip {
    /// Positions along the line, the same on the row.
    positions: Vec<f64>,
    /// Depths on the line, and on the row beside it.
    depths: [Vec<f64>; 2],
    edges: Vec<CrossEdges>,
    /// Largest distance of any sample from the planet's centre over the smallest depth.
    radius: f64,
}

/// Cells taken together.
const CELLS: usize = 4;

/// Edges of the grid from line to row, two a cell: on the line their position and depth, to the row what is added.
#[derive(Clone, Copy, Default)]
struct CrossEdges {
    position: [f64; 2 * CELLS],
    run: [f64; 2 * CELLS],
    depth: [f64; 2 * CELLS],
    rise: [f64; 2 * CELLS],
}

impl Strip {
    /// The strip between two rows of samples along a cube axis, on the face across another axis.
    pub(super) fn new(line: &[SurfacePoint], row: &[SurfacePoint], along: usize, across: usize) -> Strip {
        let depths = [line, row].map(|row| row.iter().map(|p| 1.0 / p.ideal[across].abs()).collect::<Vec<_>>());
        let least = depths.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let positions = line.iter().map(|p| p.ideal[along] / p.ideal[across].abs()).collect();
        let farthest = line.iter().chain(row).map(|p| p.ideal.length()).fold(0.0, f64::max);
        let mut strip = Strip { positions, depths, edges: Vec::new(), radius: farthest / least };
        strip.edges = (0..line.len() - 1).step_by(CELLS).map(|first| strip.edges_of(first)).collect();
        strip
    }

    /// The edges of some cells: the one between each cell and the cell before, and its diagonal. Lines have even numbers, so the
    /// diagonals of either side meet at even samples of the line.
    fn edges_of(&self, first: usize) -> CrossEdges {
        let mut edges = CrossEdges::default();
        let cells = (first..self.positions.len() - 1).take(CELLS);
        let ends = cells.flat_map(|k| [(k, k), (k + k % 2, k + 1 - k % 2)]);
        for (at, (a, b)) in ends.enumerate() {
            edges.position[at] = self.positions[a];
            edges.run[at] = self.positions[b] - self.positions[a];
            edges.depth[at] = self.depths[0][a];
            edges.rise[at] = self.depths[1][b] - self.depths[0][a];
        }
        edges
    }

    /// Largest radial error, at crossings, of the edges from `target` on the line to the samples `rim` of the row.
    pub(super) fn fan_error(&self, target: usize, rim: RangeInclusive<usize>) -> f64 {
        let error = |q: usize| {
            let (position, depth) = (self.positions[target], self.depths[0][target]);
            let new = [position, self.positions[q] - position, depth, self.depths[1][q] - depth];
            crossing_error(&self.edges[target.min(q) / CELLS..target.max(q).div_ceil(CELLS)], new)
        };
        rim.map(error).fold(0.0, f64::max) * self.radius
    }
}

/// Largest difference of depth where a new edge (position, run, depth, rise) crosses those of the grid. Edges that it does not
/// cross do not count.
#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn crossing_error(edges: &[CrossEdges], [position, run, depth, rise]: [f64; 4]) -> f64 {
    let mut worst = [0.0f64; 2 * CELLS];
    for edges in edges {
        for (k, worst) in worst.iter_mut().enumerate() {
            let across = (edges.position[k] - position) / (run - edges.run[k]);
            let error = (depth - edges.depth[k] + across * (rise - edges.rise[k])).abs();
            let counts = 0.0 < across && across < 1.0 && error > *worst;
            *worst = if counts { error } else { *worst };
        }
    }
    worst.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn strip(depth: impl Fn(f64, f64) -> f64) -> Strip {
        let row = |y: f64| -> Vec<SurfacePoint> {
            let point = |x: f64| DVec3::new(x, y, 1.0) / depth(x, y);
            (0..=8).map(|x| SurfacePoint { position: point(f64::from(x)), ideal: point(f64::from(x)) }).collect()
        };
        Strip::new(&row(0.0), &row(1.0), 0, 2)
    }

    #[test]
    fn planes_have_no_error_and_twisted_strips_do() {
        let plane = strip(|x, y| 1.0 + 0.01 * x - 0.02 * y);
        let twisted = strip(|x, y| 1.0 + 0.01 * x * y);
        for (target, q) in [(0, 3), (8, 2), (4, 4), (1, 8)] {
            assert!(plane.fan_error(target, q..=q) < 1e-14);
            assert_eq!(twisted.fan_error(target, q..=q) > 1e-3, target != q, "{target} {q}");
        }
        // The edge from (0, 0) to (4, 1), at (2, ½): the ground is 0.01 deeper than the datum, and the edge 0.02.
        let error = twisted.fan_error(0, 4..=4) / twisted.radius;
        assert!(error >= 0.01 - 1e-12, "{error}");
    }

    #[test]
    fn diagonals_of_the_grid_are_no_error() {
        let twisted = strip(|x, y| 1.0 + 0.01 * x * y);
        assert_eq!(twisted.fan_error(2, 1..=3), 0.0);
        assert!(twisted.fan_error(3, 2..=2) > 0.0 && twisted.fan_error(3, 4..=4) > 0.0);
    }
}
