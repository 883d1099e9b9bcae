//! The samples of a patch as the simplifier sees them.
//!
//! Seen from the planet's centre a triangle is a triangle again in the gnomonic plane of its face, where the warped face
//! coordinates of the grid are the columns and rows, and the reciprocal of the distance along the face's normal is an affine
//! function on every triangle. So containment is a 2D orientation, radial interpolation is one affine evaluation, and
//! the sides of a patch are exactly straight.

use crate::ground::{Ground, HeightGrid};
use crate::lattice::LatticeBox;
use glam::{DVec3, IVec3};

/// Least doubled area, in grid cells, of a triangle that a collapse may create.
pub const LEAST_AREA: f64 = 0.05;

/// One grid vertex in the gnomonic plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Column, in mean cell widths from the patch's first corner.
    pub x: f64,
    /// Row, in mean cell heights from the patch's first corner.
    pub y: f64,
    /// Planet radius over distance along the face normal.
    pub q: f64,
    /// Radial distance in lattice units for a unit change of `q`, times `q`.
    pub gain: f64,
}

impl Sample {
    /// Radial distance in lattice units between this sample and a surface that has reciprocal depth `q` here.
    #[inline]
    pub fn radial_error(&self, q: f64) -> f64 {
        (q - self.q).abs() * self.gain / q
    }
}

/// Doubled signed area of a, b, c in cells.
#[inline]
pub fn area(a: &Sample, b: &Sample, c: &Sample) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// All grid vertices of a patch.
pub struct Surface {
    /// Grid cells a side.
    pub cells: u32,
    /// Gnomonic samples by vertex number j (cells + 1) + i.
    pub samples: Vec<Sample>,
    /// Exact lattice positions.
    pub positions: Vec<DVec3>,
    /// Quantised heights.
    pub heights: Vec<i32>,
    /// Box around the positions.
    pub bounds: LatticeBox,
    /// Largest radial distance in lattice units of the half-cell samples (the next level's) from the full grid.
    pub deviation: f64,
}

impl Surface {
    /// The vertices of a sampled patch.
    pub fn new(ground: &Ground, grid: &HeightGrid) -> Surface {
        let n = ground.cells as i32;
        let mut surface = Surface {
            cells: ground.cells,
            samples: Vec::new(),
            positions: Vec::new(),
            heights: Vec::new(),
            bounds: LatticeBox::EMPTY,
            deviation: 0.0,
        };
        let plane = GnomonicPlane::new(ground, grid);
        for j in 0..=n {
            for i in 0..=n {
                let position: IVec3 = grid.position(&ground.lattice, 2 * i, 2 * j);
                surface.bounds.include(position);
                surface.positions.push(position.as_dvec3());
                surface.heights.push(grid.height(2 * i, 2 * j));
                surface.samples.push(plane.sample(2 * i, 2 * j));
            }
        }
        surface.deviation = surface.half_cell_deviation(&plane) + crate::border::ROUNDING;
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
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    fn half_cell_deviation(&self, plane: &GnomonicPlane) -> f64 {
        let n = self.cells as i32;
        let mut worst = 0.0f64;
        for b in 0..=2 * n {
            for a in 0..=2 * n {
                if a % 2 == 0 && b % 2 == 0 {
                    continue;
                }
                let sample = plane.sample(a, b);
                worst = worst.max(sample.radial_error(self.grid_depth(&sample, (a / 2).min(n - 1), (b / 2).min(n - 1))));
            }
        }
        worst
    }

    /// Reciprocal depth of the full grid at a sample in cell (i, j).
    fn grid_depth(&self, sample: &Sample, i: i32, j: i32) -> f64 {
        let row = self.cells as i32 + 1;
        let at = |i: i32, j: i32| &self.samples[(j * row + i) as usize];
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
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
        let first = crate::ground::GUTTER as usize;
        let lines = [&grid.warped.columns, &grid.warped.rows];
        let origin = lines.map(|line| line[first]);
        let scale = lines.map(|line| f64::from(ground.cells) / (line[first + parts] - line[first]));
        GnomonicPlane { grid, radius: ground.lattice.radius, origin, scale }
    }

    fn sample(&self, a: i32, b: i32) -> Sample {
        let index = |k: i32| (k + crate::ground::GUTTER) as usize;
        let (x, y) = (self.grid.warped.columns[index(a)], self.grid.warped.rows[index(b)]);
        let slant = (1.0 + x * x + y * y).sqrt();
        let radius = self.radius + f64::from(self.grid.height(a, b));
        // depth = radius / slant; q = R / depth; radius error = slant |R/q' - R/q| = slant R |q - q'| / (q q').
        let q = self.radius * slant / radius;
        Sample {
            x: (x - self.origin[0]) * self.scale[0],
            y: (y - self.origin[1]) * self.scale[1],
            q,
            gain: slant * self.radius / q,
        }
    }
}
