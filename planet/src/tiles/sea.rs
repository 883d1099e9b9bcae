//! The sea of a tile: a grid of the sphere at its level, without the cells whose ground is dry.

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
    /// The sea over a patch, if there is some: a sphere to within `tolerance` metres. Cells are dry where no sample lies below the sea's level
    /// or up to `margin` metres above it, or where the sea is kept out.
    pub(super) fn over(planet: &Planet, mesh: &PatchMesh, grid: &Grid, tolerance: f64, margin: f64) -> Option<Sea> {
        let level = planet.recipe.sea.as_ref()?.level_m;
        if grid.heights.iter().all(|&height| height > level + margin) {
            return None;
        }
        let wet = wet(planet, mesh, grid, level, margin);
        let any_dry = wet.contains(&Wetness::KeptDry);
        let radius = planet.recipe.radius + level;
        let full = mesh.cells as usize;
        let cells = if any_dry { full } else { coarsest(mesh.id, radius, full, tolerance) };
        let sheet = sheet(mesh.id, radius, full, cells, &|number| wet[number] == Wetness::Wet);
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

#[derive(Clone, Copy, PartialEq, Eq)]
enum Wetness {
    Dry,
    KeptDry,
    Wet,
}

/// What the samples of a patch are.
fn wet(planet: &Planet, mesh: &PatchMesh, grid: &Grid, level: f64, margin: f64) -> Vec<Wetness> {
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
    let wetness = |(height, above): (&f64, f64)| match (*height <= level + margin, *height < level && above > 0.0) {
        (false, _) => Wetness::Dry,
        (true, true) => Wetness::KeptDry,
        (true, false) => Wetness::Wet,
    };
    grid.heights.iter().zip(above).map(wetness).collect()
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

/// Cells of the sphere with at least one wet sample of `full` cells a side.
fn sheet(id: PatchId, radius: f64, full: usize, cells: usize, is_wet: &dyn Fn(usize) -> bool) -> Sheet {
    let warped = WarpedGrid::new(id, 0..=cells as i32, cells as u32);
    let block = full / cells;
    let mut numbers = vec![u32::MAX; (cells + 1) * (cells + 1)];
    let mut sheet = Sheet::default();
    for (i, j) in (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j))) {
        let mut samples = (0..=block).flat_map(|y| (0..=block).map(move |x| (j * block + y) * (full + 1) + i * block + x));
        if !samples.any(is_wet) {
            continue;
        }
        for corners in cell_corners(cells + 1, i, j) {
            let triangle = corners.map(|v| {
                let k = v as usize;
                if numbers[k] == u32::MAX {
                    numbers[k] = sheet.positions.len() as u32;
                    sheet.positions.push(warped.direction(k % (cells + 1), k / (cells + 1)) * radius);
                    sheet.sides.push(sides_of(k, cells));
                }
                numbers[k]
            });
            sheet.triangles.push(triangle);
        }
    }
    sheet
}
