//! The heights of one patch's grid, and the ground between them: two triangles a cell, as the finest surface draws them.

use super::rays::{PatchSurface, Ray};
use crate::draw::loaded_patch::LoadedPatch;
use crate::globe::lattice::Lattice;
use crate::globe::patch::PatchId;
use crate::ground::{Ground, HeightGrid, WarpedGrid, GUTTER};
use crate::mesh::progressive::{PatchMesh, Vertex};
use glam::{DVec3, IVec3};
use std::sync::{Arc, OnceLock};
use terrane_heightfield::decimate::mesh::cell_corners;

/// Lattice units by which a direction in a cell may miss the cell's triangles, whose corners are rounded to the lattice.
const CORNER_ROUNDING: f64 = 4.0;

/// Lattice units by which patches overlap for rays.
const OVERLAP: f64 = 2.0;

/// The grid of one patch: 18 kB for 64 cells, and 85 more once a ray came near.
pub struct PatchGrid {
    /// Which patch.
    pub id: PatchId,
    /// Highest sample, lattice units above the datum.
    pub highest: i32,
    pub(super) lattice: Lattice,
    warped: WarpedGrid,
    /// By grid number, lattice units above the datum.
    heights: Box<[i32]>,
    surface: OnceLock<PatchSurface>,
}

impl PatchGrid {
    /// The grid of a built patch.
    pub fn of_mesh(mesh: &PatchMesh, lattice: &Lattice) -> PatchGrid {
        let mut heights = vec![0; mesh.vertices.len()];
        for vertex in &mesh.vertices {
            heights[usize::from(vertex.grid)] = vertex.height;
        }
        let warped = WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells);
        PatchGrid::new(mesh.id, *lattice, warped, heights)
    }

    /// The grid of a patch as far as its vertices are there: between them its samples lie on the triangles that these make.
    pub fn of_loaded(patch: &LoadedPatch, lattice: &Lattice) -> PatchGrid {
        let (mesh, lists, row) = (&patch.mesh, &patch.lists, patch.mesh.cells as usize + 1);
        let mut heights: Vec<i32> = patch.falls.iter().map(|&vertex| mesh.vertices[usize::from(vertex)].height).collect();
        if mesh.vertices.len() < heights.len() {
            let end = lists.levels.get(1).map_or(lists.triangles.len(), |coarser| coarser.start() as usize);
            lists.triangles[..end]
                .iter()
                .for_each(|corners| fill(&mut heights, row, corners.map(|k| &mesh.vertices[usize::from(k)])));
        }
        let warped = WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells);
        PatchGrid::new(mesh.id, *lattice, warped, heights)
    }

    /// Samples the grid of a patch without building it: the same heights as [`PatchGrid::of_mesh`] for a twentieth of the time.
    pub fn sample(ground: &Ground, id: PatchId) -> PatchGrid {
        let warped = WarpedGrid::new(id, 0..=ground.cells as i32, ground.cells);
        let row = |row| (0..warped.columns.len()).map(move |column| (column, row));
        let samples = (0..warped.rows.len()).flat_map(row);
        let directions: Vec<DVec3> = samples.map(|(column, row)| warped.direction(column, row)).collect();
        let heights = ground.quantised(&directions);
        PatchGrid::new(id, ground.lattice, warped, heights)
    }

    /// The grid of a patch of `cells` cells a side that was surveyed: the same again, without sampling.
    pub fn of_survey(grid: &HeightGrid, cells: u32, lattice: &Lattice) -> PatchGrid {
        let warped = WarpedGrid::new(grid.id, 0..=cells as i32, cells);
        // Every other sample, within the gutters.
        let at = |k: u32| (2 * k as i32 + GUTTER) as usize;
        let row = |row: u32| (0..=cells).map(move |column| at(row) * grid.side + at(column));
        let heights = (0..=cells).flat_map(row).map(|sample| grid.heights[sample]).collect();
        PatchGrid::new(grid.id, *lattice, warped, heights)
    }

    fn new(id: PatchId, lattice: Lattice, warped: WarpedGrid, heights: Vec<i32>) -> PatchGrid {
        let highest = heights.iter().copied().max().unwrap_or(0);
        PatchGrid { id, highest, lattice, warped, heights: heights.into(), surface: OnceLock::new() }
    }

    /// Grid cells a side.
    pub fn cells(&self) -> u32 {
        self.warped.columns.len() as u32 - 1
    }

    /// Distance of the ground from the planet's centre in a unit direction within the patch, in lattice units. `None` for
    /// directions elsewhere.
    pub fn radius(&self, direction: DVec3) -> Option<f64> {
        let ray = Ray { origin: DVec3::ZERO, direction };
        let (u, v) = self.id.face.project(direction);
        let [i, j] = [cell_of(&self.warped.columns, u), cell_of(&self.warped.rows, v)];
        let around = |k: usize| k.saturating_sub(1)..=(k + 1).min(self.cells() as usize - 1);
        // The rounding of corners can bring a neighbour's triangle here; over a side of the patch the plane of the own one goes on.
        self.meet_cell(&ray, [i, j], 0.0)
            .or_else(|| around(j).find_map(|j| around(i).find_map(|i| self.meet_cell(&ray, [i, j], 0.0))))
            .or_else(|| self.meet_cell(&ray, [i, j], CORNER_ROUNDING))
    }

    fn meet_cell(&self, ray: &Ray, [i, j]: [usize; 2], margin: f64) -> Option<f64> {
        let triangles = cell_corners(self.warped.columns.len(), i, j);
        triangles.into_iter().find_map(|corners| ray.distance_to(corners.map(|v| self.position(v).as_dvec3()), margin))
    }

    /// Lattice position of a grid number.
    fn position(&self, v: u32) -> IVec3 {
        let (row, v) = (self.warped.columns.len(), v as usize);
        self.lattice.position(self.warped.direction(v % row, v / row), self.heights[v])
    }

    /// Distance along a ray to the nearest triangle. `triangles` from [`grouped_grid`](super::rays::patch_surface::grouped_grid).
    pub(super) fn nearest(&self, ray: &Ray, triangles: &Arc<[[u32; 3]]>) -> Option<f64> {
        self.surface.get_or_init(|| PatchSurface::of_positions(self.overlapping(), triangles)).nearest(ray)
    }

    /// Positions by grid number, those on the border moved out by a little more than corners are rounded by: a ray along a side of
    /// the patch may pass beside all triangles of the patch that it is said to be in.
    fn overlapping(&self) -> Vec<IVec3> {
        let mut positions: Vec<IVec3> = (0..self.heights.len() as u32).map(|v| self.position(v)).collect();
        let (row, last) = (self.warped.columns.len(), self.heights.len() - 1);
        let mut move_out = |border: usize, inner: usize| {
            let outward = (positions[border] - positions[inner]).as_dvec3().normalize_or_zero();
            positions[border] += (outward * OVERLAP).round().as_ivec3();
        };
        for k in 0..row {
            move_out(k * row, k * row + 1);
            move_out(k * row + row - 1, k * row + row - 2);
        }
        for k in 0..row {
            move_out(k, k + row);
            move_out(last - k, last - k - row);
        }
        positions
    }
}

/// Gives the samples of a grid with `row` of them a row, as far as they lie in a triangle, its heights.
fn fill(heights: &mut [i32], row: usize, corners: [&Vertex; 3]) {
    let [a, b, c] = corners.map(|v| [usize::from(v.grid) % row, usize::from(v.grid) / row].map(|at| at as i64));
    let twice_area = |p: [i64; 2], q: [i64; 2], r: [i64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let area = twice_area(a, b, c);
    let range = |axis: usize| {
        let of = [a[axis], b[axis], c[axis]];
        of.into_iter().fold(of[0], i64::min)..=of.into_iter().fold(of[0], i64::max)
    };
    for y in range(1) {
        for x in range(0) {
            let weights = [twice_area([x, y], b, c), twice_area(a, [x, y], c), twice_area(a, b, [x, y])];
            if area > 0 && weights.iter().all(|&weight| weight >= 0) {
                let sum: i64 = weights.iter().zip(corners).map(|(weight, corner)| weight * i64::from(corner.height)).sum();
                heights[y as usize * row + x as usize] = sum.div_euclid(area) as i32;
            }
        }
    }
}

/// The interval of a rising line that a value falls in.
fn cell_of(line: &[f64], value: f64) -> usize {
    line.partition_point(|&x| x <= value).clamp(1, line.len() - 1) - 1
}
