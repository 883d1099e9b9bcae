//! The samples of a patch as the simplifier sees them.
//!
//! Seen from the planet's centre a triangle is a triangle again in the gnomonic plane of its face, where the warped face
//! coordinates of the grid are the columns and rows, and the reciprocal of the distance along the face's normal is an affine
//! function on every triangle. So containment is a 2D orientation, radial interpolation is one affine evaluation, and
//! the sides of a patch are exactly straight.

use super::progressive::Quarter;
use crate::globe::lattice::LatticeBox;
use crate::ground::{Ground, HeightGrid, GUTTER};
use glam::IVec3;
use terrane_heightfield::decimate::samples::{area, Sample, Samples};

/// All grid vertices of a patch.
pub struct Surface {
    /// Grid cells a side.
    pub cells: u32,
    /// Gnomonic samples by vertex number j (cells + 1) + i, the depth being the planet's radius over the distance along the face
    /// normal.
    pub samples: Samples,
    /// Exact lattice positions.
    pub positions: Vec<IVec3>,
    /// Quantised heights.
    pub heights: Vec<i32>,
    /// Radius of the planet in lattice units.
    pub radius: f64,
    /// Box around the positions.
    pub bounds: LatticeBox,
    /// The half-cell samples (the next level's) of every quarter, and their distance from the full grid.
    pub quarters: [Quarter; 4],
}

impl Surface {
    /// The vertices of a sampled patch.
    pub fn new(ground: &Ground, grid: &HeightGrid) -> Surface {
        let plane = GnomonicPlane::new(ground, grid);
        let steps = 0..=ground.cells as i32;
        let points = steps.clone().flat_map(|j| steps.clone().map(move |i| (2 * i, 2 * j)));
        let [columns, rows] = [0, 1].map(|axis| steps.clone().map(|k| plane.line(axis, 2 * k)).collect());
        let mut surface = Surface {
            cells: ground.cells,
            samples: Samples::new(columns, rows, points.clone().map(|(a, b)| plane.sample(a, b).q)),
            positions: points.clone().map(|(a, b)| grid.position(&ground.lattice, a, b)).collect(),
            heights: points.map(|(a, b)| grid.height(a, b)).collect(),
            radius: ground.lattice.radius,
            bounds: LatticeBox::EMPTY,
            quarters: [Quarter { heights: [i32::MAX, i32::MIN], deviation: super::border::ROUNDING }; 4],
        };
        surface.positions.iter().for_each(|&p| surface.bounds.include(p));
        surface.measure_quarters(&plane);
        surface
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are no vertices (never for a built surface).
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Distance between two vertices in lattice units.
    #[inline]
    pub fn distance(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].as_dvec3().distance(self.positions[b as usize].as_dvec3())
    }

    /// Distance of a vertex from the planet's centre in lattice units.
    #[inline]
    pub fn distance_from_centre(&self, v: u32) -> f64 {
        self.radius + f64::from(self.heights[v as usize])
    }

    /// Radial distance in lattice units between vertex `v`, which has depth `own`, and a surface of another depth there.
    ///
    /// With radius r and slant g the depth is q = R g / r, so |r - r'| = |q - q'| r / q'.
    #[inline]
    pub fn radial_error(&self, v: u32, own: f64, depth: f64) -> f64 {
        (depth - own).abs() * self.distance_from_centre(v) / depth
    }

    /// Measures the half-cell samples, quarter by quarter; those on the middle lines belong to both sides.
    fn measure_quarters(&mut self, plane: &GnomonicPlane) {
        let half = self.cells as i32 / 2;
        for (k, [column, row]) in [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [x * half, y * half]).into_iter().enumerate() {
            let heights = (2 * row..=2 * (row + half)).map(|b| {
                let first = plane.grid.index(2 * column, b);
                let run = &plane.grid.heights[first..=first + 2 * half as usize];
                run.iter().fold([i32::MAX, i32::MIN], |[low, high], &h| [low.min(h), high.max(h)])
            });
            self.quarters[k].heights = heights.fold([i32::MAX, i32::MIN], |all, row| [all[0].min(row[0]), all[1].max(row[1])]);
            self.quarters[k].deviation += self.deviation_in(plane, [column, row], half);
        }
    }

    /// Largest radial distance of the half-cell samples from the full grid, in a square of so many cells from a cell on.
    fn deviation_in(&self, plane: &GnomonicPlane, [column, row]: [i32; 2], cells: i32) -> f64 {
        let n = self.cells as i32;
        let at = |i: i32, j: i32| self.samples.at((j * (n + 1) + i) as u32);
        let error = |sample: &Sample, depth: f64, a: i32, b: i32| (depth - sample.q).abs() * plane.distance(a, b) / depth;
        let (right, top) = (column + cells, row + cells);
        let mut worst = 0.0f64;
        for (i, j) in (row..=top).flat_map(|j| (column..=right).map(move |i| (i, j))) {
            let corner = at(i, j);
            // Half-cell samples on grid lines lie on edges of triangles; only those inside cells need their triangle.
            if i < right {
                let (sample, end) = (plane.sample(2 * i + 1, 2 * j), at(i + 1, j));
                let depth = corner.q + (end.q - corner.q) * ((sample.x - corner.x) / (end.x - corner.x));
                worst = worst.max(error(&sample, depth, 2 * i + 1, 2 * j));
            }
            if j < top {
                let (sample, end) = (plane.sample(2 * i, 2 * j + 1), at(i, j + 1));
                let depth = corner.q + (end.q - corner.q) * ((sample.y - corner.y) / (end.y - corner.y));
                worst = worst.max(error(&sample, depth, 2 * i, 2 * j + 1));
            }
            if i < right && j < top {
                let sample = plane.sample(2 * i + 1, 2 * j + 1);
                worst = worst.max(error(&sample, self.grid_depth(&sample, i, j), 2 * i + 1, 2 * j + 1));
            }
        }
        worst
    }

    /// Reciprocal depth of the full grid at a sample in cell (i, j).
    fn grid_depth(&self, sample: &Sample, i: i32, j: i32) -> f64 {
        let row = self.cells as i32 + 1;
        let at = |i: i32, j: i32| self.samples.at((j * row + i) as u32);
        let [a, b, c, d] = &[at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        let triangle = if (i + j) % 2 == 0 {
            if area(a, d, sample) <= 0.0 {
                [a, b, d]
            } else {
                [a, d, c]
            }
        } else if area(b, c, sample) >= 0.0 {
            [a, b, c]
        } else {
            [b, d, c]
        };
        let [p, q, r] = triangle;
        let total = area(p, q, r);
        (area(sample, q, r) * p.q + area(p, sample, r) * q.q + area(p, q, sample) * r.q) / total
    }
}

/// Maps half-cell samples of a patch into the gnomonic plane of its face.
struct GnomonicPlane<'a> {
    grid: &'a HeightGrid,
    radius: f64,
    origin: [f64; 2],
    scale: [f64; 2],
}

impl<'a> GnomonicPlane<'a> {
    fn new(ground: &Ground, grid: &'a HeightGrid) -> Self {
        let parts = 2 * ground.cells as usize;
        let first = GUTTER as usize;
        let lines = [&grid.warped.columns, &grid.warped.rows];
        let origin = lines.map(|line| line[first]);
        let scale = lines.map(|line| f64::from(ground.cells) / (line[first + parts] - line[first]));
        GnomonicPlane { grid, radius: ground.lattice.radius, origin, scale }
    }

    /// Position of a column (axis 0) or row (axis 1) of half cells, in mean cells from the patch's first corner.
    fn line(&self, axis: usize, k: i32) -> f64 {
        let lines = [&self.grid.warped.columns, &self.grid.warped.rows];
        (lines[axis][(k + GUTTER) as usize] - self.origin[axis]) * self.scale[axis]
    }

    /// Distance of a half-cell sample from the planet's centre.
    fn distance(&self, a: i32, b: i32) -> f64 {
        self.radius + f64::from(self.grid.height(a, b))
    }

    fn sample(&self, a: i32, b: i32) -> Sample {
        let index = |k: i32| (k + GUTTER) as usize;
        let (x, y) = (self.grid.warped.columns[index(a)], self.grid.warped.rows[index(b)]);
        let slant = (1.0 + x * x + y * y).sqrt();
        Sample { x: self.line(0, a), y: self.line(1, b), q: self.radius * slant / self.distance(a, b) }
    }
}
