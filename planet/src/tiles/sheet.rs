//! Triangles of a tile before they have its numbers: the ground of a patch with its least important vertices left out, or a piece of sea.

use super::frame::Frame;
use super::grid::{projected, Grid};
use crate::globe::lattice::Lattice;
use crate::globe::patch::{PatchId, Side};
use crate::ground::WarpedGrid;
use crate::mesh::progressive::{PatchMesh, Vertex};
use crate::mesh::wake::Wake;
use glam::{DVec3, IVec3};
use std::collections::{HashMap, HashSet};
use terrane_heightfield::decimate::mesh::grid_triangles;

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
                // Not on the lattice: deep down its rounding would move vertices off the sides.
                sheet.positions.push(direction * ((lattice.radius + f64::from(vertex.height)) * lattice.unit));
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

    /// The largest wake that can sleep so that the mesh lies within some metres of its full grid.
    pub(super) fn asleep_within(mesh: &PatchMesh, lattice: &Lattice, grid: &Grid, tolerance: f64) -> Wake {
        let mut wakes: Vec<Wake> = mesh.vertices.iter().map(|vertex| vertex.wake).filter(|&wake| wake < Wake::ALWAYS).collect();
        wakes.push(Wake::ASLEEP);
        wakes.sort_unstable();
        wakes.dedup();
        let (mut good, mut bad) = (0, wakes.len());
        while bad - good > 1 {
            let middle = (good + bad) / 2;
            let error = Sheet::of_ground(mesh, lattice, wakes[middle]).deviation(mesh.id, grid);
            *(if error <= tolerance { &mut good } else { &mut bad }) = middle;
        }
        wakes[good]
    }

    /// Corners of the box around it.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.positions.iter().fold(nothing, |[low, high], &p| [low.min(p), high.max(p)])
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

    /// Adds walls towards the planet's centre along the sides. Out: for each vertex the one above it, which may be itself.
    pub(super) fn add_skirts(&mut self, skirts: &Skirts, frame: &Frame) -> Vec<u32> {
        let mut above: Vec<u32> = (0..self.positions.len() as u32).collect();
        for side in Side::ALL {
            let mut feet = HashMap::new();
            for [a, b] in self.rim(side) {
                let [c, d] = [a, b].map(|v| {
                    *feet.entry(v).or_insert_with(|| {
                        above.push(v);
                        let foot = self.below(v, skirts.depths[side as usize], skirts.flare, frame);
                        self.push(foot, self.sides[v as usize])
                    })
                });
                self.triangles.extend([[b, a, c], [b, c, d]]);
            }
        }
        above
    }

    /// The walls that go deeper, from somewhat above the feet of shallow ones. Out, too: for each of their vertices the one of this sheet above it.
    pub(super) fn deep_skirts(&self, shallow: &Skirts, deep: &Skirts, frame: &Frame) -> (Sheet, Vec<u32>) {
        let (mut walls, mut above) = (Sheet::default(), Vec::new());
        for side in Side::ALL {
            let [from, to] = [shallow, deep].map(|skirts| skirts.depths[side as usize]);
            let mut posts = HashMap::new();
            for [a, b] in self.rim(side).into_iter().filter(|_| to > from) {
                let [[a, c], [b, d]] = [a, b].map(|v| {
                    *posts.entry(v).or_insert_with(|| {
                        [(from / 2.0, shallow.flare), (to, deep.flare)].map(|(depth, flare)| {
                            above.push(v);
                            walls.push(self.below(v, depth, flare, frame), self.sides[v as usize])
                        })
                    })
                });
                walls.triangles.extend([[b, a, c], [b, c, d]]);
            }
        }
        (walls, above)
    }

    fn push(&mut self, position: DVec3, sides: u8) -> u32 {
        self.positions.push(position);
        self.sides.push(sides);
        self.positions.len() as u32 - 1
    }

    /// The point so many metres below a vertex, and so many outside of its sides.
    fn below(&self, v: u32, depth: f64, flare: f64, frame: &Frame) -> DVec3 {
        let top = self.positions[v as usize];
        top * (1.0 - depth / top.length()).max(0.0) + frame.outward(self.sides[v as usize]) * flare
    }

    /// Edges on a side that only one triangle has.
    fn rim(&self, side: Side) -> Vec<[u32; 2]> {
        let on_side = |&v: &u32| self.sides[v as usize] & side.bit() != 0;
        let edges = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).filter(|edge| edge.iter().all(on_side));
        let edges: HashSet<[u32; 2]> = edges.collect();
        let mut rim: Vec<[u32; 2]> = edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect();
        rim.sort_unstable();
        rim
    }
}

/// Walls: how deep on each side, in the order of [`Side::ALL`], and how far outside their feet stand, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Skirts {
    pub(super) depths: [f64; 4],
    pub(super) flare: f64,
}

impl Skirts {
    /// The same, so deep at most.
    pub(super) fn within(&self, most: f64) -> Skirts {
        // Feet half as far outside as the walls are deep show from few places.
        Skirts { depths: self.depths.map(|depth| depth.min(most)), flare: self.flare.min(most / 4.0) }
    }
}
