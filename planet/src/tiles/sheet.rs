//! Triangles of a tile before they have its numbers: the ground of a patch with its least important vertices left out, or a piece of sea.

use super::frame::Frame;
use super::grid::{projected, Grid};
use crate::globe::lattice::Lattice;
use crate::globe::patch::{PatchId, Side};
use crate::ground::WarpedGrid;
use crate::mesh::progressive::{PatchMesh, Vertex};
use crate::mesh::wake::Wake;
use glam::{DVec3, IVec3};
use std::collections::HashSet;
use terrane_heightfield::decimate::mesh::grid_triangles;

/// Times that the search for the fewest vertices halves what is left.
const HALVINGS: usize = 12;

/// Triangles over a patch, or over a part of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sheet {
    /// Metres from the planet's centre.
    pub(super) positions: Vec<DVec3>,
    /// Sides of the patch that each vertex lies on, a bit each.
    pub(super) sides: Vec<u8>,
    /// Corners, counter-clockwise from outside.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Sides of a patch that a grid number lies on, a bit each.
pub(super) fn sides_of(number: usize, cells: usize) -> u8 {
    let (i, j) = (number % (cells + 1), number / (cells + 1));
    let on = [(Side::Left, i == 0), (Side::Right, i == cells), (Side::Bottom, j == 0), (Side::Top, j == cells)];
    on.into_iter().filter(|(_, on)| *on).map(|(side, _)| side.bit()).sum()
}

impl Sheet {
    /// The mesh of a patch in which the vertices are awake whose wakes are above one threshold.
    pub(super) fn of_ground(mesh: &PatchMesh, lattice: &Lattice, asleep: Wake) -> Sheet {
        let (cells, warped) = (mesh.cells as usize, WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells));
        let is_awake = |k: usize, vertex: &Vertex| vertex.wake > asleep || usize::from(vertex.parent) == k;
        let mut drawn_as = vec![0_u32; mesh.vertices.len()];
        let mut by_grid = vec![0_u32; mesh.vertices.len()];
        let mut sheet = Sheet::default();
        // Parents come before their children.
        for (k, vertex) in mesh.vertices.iter().enumerate() {
            drawn_as[k] = if is_awake(k, vertex) {
                let grid = usize::from(vertex.grid);
                let direction = warped.direction(grid % (cells + 1), grid / (cells + 1));
                sheet.positions.push(lattice.position(direction, vertex.height).as_dvec3() * lattice.unit);
                sheet.sides.push(sides_of(grid, cells));
                sheet.positions.len() as u32 - 1
            } else {
                drawn_as[usize::from(vertex.parent)]
            };
            by_grid[usize::from(vertex.grid)] = drawn_as[k];
        }
        let drawn = grid_triangles(mesh.cells).into_iter().map(|t| t.map(|v| by_grid[v as usize]));
        sheet.triangles = drawn.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        sheet
    }

    /// The largest wake that can sleep so that the mesh lies within some metres of its full grid, and how far off it lies then.
    pub(super) fn asleep_within(mesh: &PatchMesh, lattice: &Lattice, grid: &Grid, tolerance: f64) -> (Wake, f64) {
        let mut wakes: Vec<Wake> = mesh.vertices.iter().map(|vertex| vertex.wake).filter(|&wake| wake < Wake::ALWAYS).collect();
        wakes.push(Wake::ASLEEP);
        wakes.sort_unstable();
        wakes.dedup();
        let error = |wake: Wake| Sheet::of_ground(mesh, lattice, wake).deviation(mesh.id, grid);
        let (mut good, mut bad) = (0, wakes.len());
        let mut found = error(wakes[0]);
        for _ in 0..HALVINGS {
            if bad - good < 2 {
                break;
            }
            let middle = (good + bad) / 2;
            let error = error(wakes[middle]);
            if error <= tolerance {
                (good, found) = (middle, error);
            } else {
                bad = middle;
            }
        }
        (wakes[good], found)
    }

    /// Radial distance in metres from the full grid.
    pub(super) fn deviation(&self, id: PatchId, grid: &Grid) -> f64 {
        let corners: Vec<_> = self.positions.iter().map(|&p| projected(id.face, p)).collect();
        grid.deviation(&corners, &self.triangles)
    }

    /// The same in a frame, with its rounding.
    pub(super) fn rounded_deviation(&self, id: PatchId, grid: &Grid, frame: &Frame) -> f64 {
        let corners: Vec<_> = self.steps(frame).into_iter().map(|p| projected(id.face, frame.metres(p))).collect();
        grid.deviation(&corners, &self.triangles)
    }

    /// Its vertices in steps of a frame.
    pub(super) fn steps(&self, frame: &Frame) -> Vec<IVec3> {
        self.positions.iter().zip(&self.sides).map(|(&p, &sides)| frame.steps(p, sides)).collect()
    }

    /// Adds walls towards the planet's centre along the sides, each so many metres deep. Out: for each vertex the one above it, which
    /// may be itself.
    pub(super) fn add_skirts(&mut self, depths: [f64; 4]) -> Vec<u32> {
        let edges: HashSet<[u32; 2]> = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let mut rim: Vec<[u32; 2]> = edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect();
        rim.sort_unstable();
        let mut above: Vec<u32> = (0..self.positions.len() as u32).collect();
        for side in Side::ALL {
            let depth = depths[side as usize];
            let mut bottoms = std::collections::HashMap::new();
            let on_side = |v: u32| self.sides[v as usize] & side.bit() != 0;
            let edges: Vec<[u32; 2]> = rim.iter().copied().filter(|&[a, b]| on_side(a) && on_side(b)).collect();
            for [a, b] in edges {
                let [c, d] = [a, b].map(|v| {
                    *bottoms.entry(v).or_insert_with(|| {
                        let top = self.positions[v as usize];
                        self.positions.push(top * (1.0 - depth / top.length()).max(0.0));
                        self.sides.push(self.sides[v as usize]);
                        above.push(v);
                        self.positions.len() as u32 - 1
                    })
                });
                self.triangles.extend([[b, a, c], [b, c, d]]);
            }
        }
        above
    }
}
