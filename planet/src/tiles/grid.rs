//! The full grid of a patch in the gnomonic plane of its face, and how far triangles lie off it.
//!
//! Seen from the planet's centre, triangles stay triangles in that plane, and the reciprocal of the distance along the face's normal is
//! affine on each. So the radial distance between two surfaces is largest where an edge of one meets a vertex or an edge of the other: it is
//! measured there, and nowhere else.

use crate::globe::lattice::Lattice;
use crate::globe::sphere::Face;
use crate::ground::WarpedGrid;
use crate::mesh::progressive::PatchMesh;
use glam::DVec3;
use terrane_heightfield::decimate::samples::{area, Sample};

/// Share of a triangle by which a sample may miss it and still lie in it.
const MISS: f64 = 1e-6;

/// A full grid: its samples are ideal, exactly above their cube points.
pub(super) struct Grid {
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// One over the metres along the face's normal, by grid number.
    depths: Vec<f64>,
    /// Metres above the datum, by grid number.
    pub(super) heights: Vec<f64>,
}

/// A point in metres from the planet's centre as it lies in the gnomonic plane.
pub(super) fn projected(face: Face, p: DVec3) -> Sample {
    let ((u, v), along) = (face.grid_axes(), p[face.normal_axis()].abs());
    Sample { x: p[u] / along, y: p[v] / along, q: 1.0 / along }
}

/// Distance from the planet's centre for every metre along the face's normal.
fn slant(x: f64, y: f64) -> f64 {
    (1.0 + x * x + y * y).sqrt()
}

impl Grid {
    /// The full grid of a mesh.
    pub(super) fn of(mesh: &PatchMesh, lattice: &Lattice) -> Grid {
        let warped = WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells);
        let (columns, rows) = (warped.columns, warped.rows);
        let mut grid =
            Grid { depths: vec![0.0; columns.len() * rows.len()], heights: vec![0.0; columns.len() * rows.len()], columns, rows };
        let side = grid.columns.len();
        for vertex in &mesh.vertices {
            let k = usize::from(vertex.grid);
            let radius = (lattice.radius + f64::from(vertex.height)) * lattice.unit;
            grid.depths[k] = slant(grid.columns[k % side], grid.rows[k / side]) / radius;
            grid.heights[k] = f64::from(vertex.height) * lattice.unit;
        }
        grid
    }

    /// Samples a side.
    pub(super) fn side(&self) -> usize {
        self.columns.len()
    }

    fn sample(&self, i: usize, j: usize) -> Sample {
        Sample { x: self.columns[i], y: self.rows[j], q: self.depths[j * self.side() + i] }
    }

    /// Largest radial distance in metres of triangles from the grid; infinite if they leave a sample out.
    pub(super) fn deviation(&self, corners: &[Sample], triangles: &[[u32; 3]]) -> f64 {
        let side = self.side();
        let mut worst = 0.0_f64;
        let mut covered = vec![false; side * side];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| &corners[v as usize]);
            let total = area(a, b, c);
            if total <= 0.0 {
                continue;
            }
            let within = |line: &[f64], of: [f64; 3]| {
                let [low, high] = [of.into_iter().fold(f64::MAX, f64::min), of.into_iter().fold(f64::MIN, f64::max)];
                let slack = MISS * (high - low);
                line.partition_point(|&x| x < low - slack)..line.partition_point(|&x| x <= high + slack)
            };
            let columns = within(&self.columns, [a.x, b.x, c.x]);
            for j in within(&self.rows, [a.y, b.y, c.y]) {
                for i in columns.clone() {
                    let p = self.sample(i, j);
                    let shares = [area(&p, b, c), area(a, &p, c), area(a, b, &p)].map(|part| part / total);
                    if shares.iter().all(|&share| share >= -MISS) {
                        covered[j * side + i] = true;
                        worst = worst.max(self.apart(&p, shares[0] * a.q + shares[1] * b.q + shares[2] * c.q));
                    }
                }
            }
            for [from, to] in [[a, b], [b, c], [c, a]] {
                // Every inner edge once.
                if (from.x, from.y) < (to.x, to.y) {
                    worst = worst.max(self.along(from, to));
                }
            }
        }
        if covered.contains(&false) {
            return f64::INFINITY;
        }
        worst
    }

    /// Radial distance between the grid at a sample and a surface of another depth there.
    fn apart(&self, grid: &Sample, depth: f64) -> f64 {
        slant(grid.x, grid.y) * (1.0 / grid.q - 1.0 / depth).abs()
    }

    /// Largest radial distance of an edge from the grid, where it meets the edges of the grid.
    fn along(&self, from: &Sample, to: &Sample) -> f64 {
        let mut shares = vec![0.0, 1.0];
        let mut cross = |line: &[f64], from: f64, to: f64| {
            let (low, high) = (from.min(to), from.max(to));
            let first = line.partition_point(|&x| x <= low);
            shares.extend(line[first..].iter().take_while(|&&x| x < high).map(|&x| (x - from) / (to - from)));
        };
        cross(&self.columns, from.x, to.x);
        cross(&self.rows, from.y, to.y);
        shares.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let mix = |a: f64, b: f64| a + (b - a) * share;
            Sample { x: mix(from.x, to.x), y: mix(from.y, to.y), q: mix(from.q, to.q) }
        };
        let mut worst = 0.0_f64;
        for pair in shares.windows(2) {
            let middle = at((pair[0] + pair[1]) / 2.0);
            let [i, j] = [cell_of(&self.columns, middle.x), cell_of(&self.rows, middle.y)];
            let [p, q] = [at(pair[0]), at(pair[1])];
            let mut error =
                |point: Sample| worst = worst.max(self.apart(&Sample { q: self.depth_in([i, j], &point), ..point }, point.q));
            let [d0, d1] = [p, q].map(|end| self.beside_diagonal([i, j], &end));
            if d0 * d1 < 0.0 {
                error(at(pair[0] + (pair[1] - pair[0]) * d0 / (d0 - d1)));
            }
            error(p);
            error(q);
        }
        worst
    }

    /// On which side of the diagonal of a cell a point lies: positive left of it, going up.
    fn beside_diagonal(&self, [i, j]: [usize; 2], p: &Sample) -> f64 {
        if (i + j).is_multiple_of(2) {
            area(&self.sample(i, j), &self.sample(i + 1, j + 1), p)
        } else {
            area(&self.sample(i + 1, j), &self.sample(i, j + 1), p)
        }
    }

    /// Depth of the grid at a point in a cell, or beside it.
    fn depth_in(&self, [i, j]: [usize; 2], p: &Sample) -> f64 {
        let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| self.sample(i + x, j + y));
        let first = self.beside_diagonal([i, j], p);
        let [a, b, c] = match ((i + j).is_multiple_of(2), first > 0.0) {
            (true, false) => [a, b, d],
            (true, true) => [a, d, c],
            (false, true) => [a, b, c],
            (false, false) => [b, d, c],
        };
        (area(p, &b, &c) * a.q + area(&a, p, &c) * b.q + area(&a, &b, p) * c.q) / area(&a, &b, &c)
    }
}

/// The interval of a rising line that a value falls in.
fn cell_of(line: &[f64], value: f64) -> usize {
    line.partition_point(|&x| x <= value).clamp(1, line.len() - 1) - 1
}
