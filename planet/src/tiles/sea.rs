//! The sea of a tile: a grid of the sphere at its level where the patch has samples below it, and nowhere else.
//!
//! On the open sea its cells are as large as the sphere allows; along coasts they are those of the patch, since coarse ground may dip below the
//! sea far inland, by less than its error, and would drown there.

use super::frame::Frame;
use super::grid::Grid;
use super::sheet::{sides_of, Sheet};
use crate::globe::patch::PatchId;
use crate::globe::sphere::direction;
use crate::ground::{GroundColour, GroundPoint, WarpedGrid};
use crate::mesh::progressive::PatchMesh;
use crate::planet::Planet;
use terrane_heightfield::decimate::mesh::cell_corners;

/// A piece of sea.
pub(super) struct Sea {
    /// Metres from the planet's centre.
    radius: f64,
    /// Its triangles, with vertices at that radius.
    pub(super) sheet: Sheet,
}

impl Sea {
    /// The sea over a patch, if there is some: on open sea the sphere to within `tolerance` metres.
    pub(super) fn over(planet: &Planet, mesh: &PatchMesh, grid: &Grid, tolerance: f64) -> Option<Sea> {
        let level = planet.recipe.sea.as_ref()?.level_m;
        if grid.heights.iter().all(|&height| height >= level) {
            return None;
        }
        let (wet, radius) = (wet(planet, mesh, grid, level), planet.recipe.radius + level);
        let full = mesh.cells as usize;
        let sheet = Cells { id: mesh.id, full, cells: coarsest(mesh.id, radius, full, tolerance), wet }.sheet(radius);
        (!sheet.triangles.is_empty()).then_some(Sea { radius, sheet })
    }

    /// Largest radial distance in metres of its triangles from the sphere, as a frame rounds them.
    pub(super) fn error(&self, frame: &Frame) -> f64 {
        let points: Vec<_> = self.sheet.steps(frame).into_iter().map(|p| frame.metres(p)).collect();
        let off = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| points[v as usize]);
            // Nothing of a triangle is nearer to the centre than its plane, nor farther away than a corner.
            let nearest = (b - a).cross(c - a).normalize_or_zero().dot(a);
            let farthest = [a, b, c].map(|p| p.length()).into_iter().fold(0.0, f64::max);
            (self.radius - nearest).abs().max((farthest - self.radius).abs())
        };
        self.sheet.triangles.iter().map(off).fold(0.0, f64::max)
    }
}

/// Which samples of a patch the sea covers.
fn wet(planet: &Planet, mesh: &PatchMesh, grid: &Grid, level: f64) -> Vec<bool> {
    let warped = WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells);
    let side = grid.side();
    let point = |(k, &height): (usize, &f64)| GroundPoint {
        direction: warped.direction(k % side, k / side),
        height,
        slope: 0.0,
        north: 0.0,
        spacing: 0.0,
    };
    let points: Vec<GroundPoint> = grid.heights.iter().enumerate().map(point).collect();
    let above = GroundColour::above_sea(&planet.terrain, &points).unwrap_or_default();
    grid.heights.iter().zip(above).map(|(height, above)| *height < level && above < 0.0).collect()
}

/// The fewest cells a side whose triangles lie within a tolerance of the sphere, or as many as the patch has.
fn coarsest(id: PatchId, radius: f64, most: usize, tolerance: f64) -> usize {
    let angle = [(0, 0), (1, 1), (1, 0), (0, 1)].map(|(a, b)| direction(id.point(a, b, 1)));
    let diagonal = angle[0].angle_between(angle[1]).max(angle[2].angle_between(angle[3]));
    let mut cells = 1;
    while cells < most && radius * (1.0 - (diagonal / cells as f64 / 2.0).cos()) > tolerance {
        cells *= 2;
    }
    cells
}

/// The samples of a patch under large cells.
struct Cells {
    id: PatchId,
    /// Cells a side of the patch, and large ones.
    full: usize,
    cells: usize,
    wet: Vec<bool>,
}

/// How much of a large cell's samples are wet.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wetness {
    Dry,
    Mixed,
    Wet,
}

impl Cells {
    fn block(&self) -> usize {
        self.full / self.cells
    }

    /// The large cell in a column and a row; outside of the patch there is none.
    fn wetness(&self, i: isize, j: isize) -> Wetness {
        let inside = 0..self.cells as isize;
        if !inside.contains(&i) || !inside.contains(&j) {
            return Wetness::Dry;
        }
        let (block, i, j) = (self.block(), i as usize, j as usize);
        let samples = (0..=block).flat_map(|y| (0..=block).map(move |x| (x, y)));
        let wet = samples.filter(|(x, y)| self.wet[self.number(i * block + x, j * block + y)]).count();
        match wet {
            0 => Wetness::Dry,
            all if all == (block + 1) * (block + 1) => Wetness::Wet,
            _ => Wetness::Mixed,
        }
    }

    fn number(&self, i: usize, j: usize) -> usize {
        j * (self.full + 1) + i
    }

    /// The triangles: large cells where all is wet, small ones with a wet corner where not all is, and fans between the two.
    fn sheet(&self, radius: f64) -> Sheet {
        let block = self.block();
        let mut triangles: Vec<[usize; 3]> = Vec::new();
        for (i, j) in (0..self.cells).flat_map(|j| (0..self.cells).map(move |i| (i, j))) {
            let (x, y) = (i * block, j * block);
            match self.wetness(i as isize, j as isize) {
                Wetness::Dry => {}
                Wetness::Wet => self.large(i, j, &mut triangles),
                Wetness::Mixed => {
                    let small = (0..block).flat_map(|b| (0..block).map(move |a| (x + a, y + b)));
                    let corners = small.flat_map(|(x, y)| {
                        let pair = cell_corners(self.full + 1, x, y).map(|t| t.map(|v| v as usize));
                        let is_wet = pair.iter().flatten().any(|&v| self.wet[v]);
                        is_wet.then_some(pair).into_iter().flatten()
                    });
                    triangles.extend(corners);
                }
            }
        }
        let warped = WarpedGrid::new(self.id, 0..=self.full as i32, self.full as u32);
        let (mut numbers, mut sheet) = (vec![u32::MAX; self.wet.len()], Sheet::default());
        for triangle in triangles {
            let corners = triangle.map(|k| {
                if numbers[k] == u32::MAX {
                    numbers[k] = sheet.positions.len() as u32;
                    sheet.positions.push(warped.direction(k % (self.full + 1), k / (self.full + 1)) * radius);
                    sheet.sides.push(sides_of(k, self.full));
                }
                numbers[k]
            });
            sheet.triangles.push(corners);
        }
        sheet
    }

    /// A large cell: two triangles, or a fan that has the vertices of small cells beside it.
    fn large(&self, i: usize, j: usize, triangles: &mut Vec<[usize; 3]>) {
        let block = self.block();
        let (x, y) = (i * block, j * block);
        let is_small = |i: isize, j: isize| block > 1 && self.wetness(i, j) == Wetness::Mixed;
        let (column, row) = (i as isize, j as isize);
        let beside = [is_small(column, row - 1), is_small(column + 1, row), is_small(column, row + 1), is_small(column - 1, row)];
        if !beside.contains(&true) {
            let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[a, b]| self.number(x + a * block, y + b * block));
            triangles.extend([[a, b, d], [a, d, c]]);
            return;
        }
        // Around the cell: along the bottom, up the right side, back along the top, down the left side.
        let at = |side: usize, k: usize| match side {
            0 => self.number(x + k, y),
            1 => self.number(x + block, y + k),
            2 => self.number(x + block - k, y + block),
            _ => self.number(x, y + block - k),
        };
        let around: Vec<usize> =
            (0..4).flat_map(|side| (0..block).step_by(if beside[side] { 1 } else { block }).map(move |k| at(side, k))).collect();
        let middle = self.number(x + block / 2, y + block / 2);
        triangles.extend((0..around.len()).map(|k| [middle, around[k], around[(k + 1) % around.len()]]));
    }
}
