//! The triangles of one patch, to be hit by rays: found by obvhs, decided in f64 on exact corners.

use super::box_tree::BoxTree;
use super::Ray;
use crate::draw::layout::{DrawnVertex, PatchVertex};
use crate::globe::lattice::{Lattice, LatticeBox};
use crate::mesh::progressive::PatchMesh;
use crate::reference::position::exact_position;
use glam::{DVec3, IVec3};
use std::sync::Arc;
use terrane_heightfield::decimate::mesh::grid_triangles;

/// Grid cells along a side of a group: all triangles of a group share one box, which keeps full grids small in memory.
const GROUP: u32 = 4;

/// Triangles of one patch, with corners on the lattice or between its points.
pub struct PatchSurface<P = IVec3> {
    /// Exact corners; those of a full grid by grid number.
    pub positions: Vec<P>,
    triangles: Arc<[[u32; 3]]>,
    group: usize,
    boxes: BoxTree,
    /// Box around its triangles.
    pub bounds: LatticeBox,
}

/// Triangles of the full grid of a patch of `cells` cells a side, group by group.
pub fn grouped_grid(cells: u32) -> Arc<[[u32; 3]]> {
    let row = cells + 1;
    let mut triangles = grid_triangles(cells);
    let group_of = |t: &[u32; 3]| {
        let low = t.iter().fold((u32::MAX, u32::MAX), |low, v| (low.0.min(v % row), low.1.min(v / row)));
        (low.1 / GROUP, low.0 / GROUP)
    };
    triangles.sort_by_key(group_of);
    triangles.into()
}

impl PatchSurface {
    /// The full grid of a patch; `triangles` from [`grouped_grid`].
    pub fn of_grid(mesh: &PatchMesh, lattice: &Lattice, triangles: &Arc<[[u32; 3]]>) -> PatchSurface {
        let mut positions = vec![IVec3::ZERO; mesh.vertices.len()];
        for vertex in PatchVertex::of_patch(mesh, lattice) {
            positions[vertex.grid() as usize] = IVec3::from_array(vertex.position);
        }
        PatchSurface::of_positions(positions, triangles)
    }

    /// The full grid with corners at `positions`, by grid number; `triangles` from [`grouped_grid`].
    pub fn of_positions(positions: Vec<IVec3>, triangles: &Arc<[[u32; 3]]>) -> PatchSurface {
        PatchSurface::new(positions, triangles.clone(), (2 * GROUP * GROUP) as usize)
    }
}

impl PatchSurface<DVec3> {
    /// Drawn triangles of a patch, as vertex indices. `drawn_positions` holds as many vertices as triangles use.
    pub fn of_drawn(vertices: &[PatchVertex], drawn_positions: &[DrawnVertex], triangles: &[[u32; 3]]) -> Self {
        let positions = (0u32..).zip(drawn_positions).map(|(v, drawn)| exact_position(vertices, v, drawn.weight)).collect();
        PatchSurface::new(positions, triangles.into(), 1)
    }
}

impl<P: Copy + Into<DVec3>> PatchSurface<P> {
    fn new(positions: Vec<P>, triangles: Arc<[[u32; 3]]>, group: usize) -> Self {
        let around = |group: &[[u32; 3]]| {
            let mut bounds = LatticeBox::EMPTY;
            for &v in group.iter().flatten() {
                let position: DVec3 = positions[v as usize].into();
                bounds.include(position.floor().as_ivec3());
                bounds.include(position.ceil().as_ivec3());
            }
            bounds
        };
        let boxes: Vec<LatticeBox> = triangles.chunks(group).map(around).collect();
        let bounds = boxes.iter().fold(LatticeBox::EMPTY, |all, &one| all.union(one));
        PatchSurface { boxes: BoxTree::new(&boxes), positions, triangles, group, bounds }
    }

    /// Distance along the ray to the nearest triangle.
    pub fn nearest(&self, ray: &Ray) -> Option<f64> {
        self.nearest_triangle(ray).map(|(distance, _)| distance)
    }

    /// The nearest triangle on the ray, and its distance.
    pub fn nearest_triangle(&self, ray: &Ray) -> Option<(f64, [u32; 3])> {
        let mut nearest: Option<(f64, [u32; 3])> = None;
        let in_group = |k: usize| {
            let first = k * self.group;
            let last = (first + self.group).min(self.triangles.len());
            let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize].into());
            let hits = self.triangles[first..last].iter().filter_map(|t| Some((ray.distance_to(corners(t), 0.0)?, *t)));
            let (distance, triangle) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if nearest.is_none_or(|(found, _)| distance < found) {
                nearest = Some((distance, triangle));
            }
            Some(distance)
        };
        self.boxes.nearest(ray, in_group);
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(position: [i32; 3]) -> PatchVertex {
        PatchVertex { position, ..Default::default() }
    }

    #[test]
    fn heights_of_a_triangle_far_from_the_centre_are_exact() {
        let far = 1 << 30;
        let vertices = [[far, 0, 0], [far, 900, 0], [far + 300, 0, 900]].map(vertex);
        let surface = PatchSurface::of_drawn(&vertices, &[DrawnVertex::default(); 3], &[[0, 1, 2]]);
        let through = DVec3::new(f64::from(far) + 100.0, 300.0, 300.0);
        let found = surface.nearest(&Ray::radial(through)).unwrap();
        assert!((found - through.length()).abs() < 1e-5, "{}", found - through.length());
        assert_eq!(surface.nearest(&Ray::radial(DVec3::new(f64::from(far), 500.0, 500.0))), None);
        let down = Ray { origin: through + DVec3::X * 5000.0, direction: -DVec3::X };
        assert!((surface.nearest(&down).unwrap() - 5000.0).abs() < 1e-9);
    }

    #[test]
    fn triangles_beside_a_ray_are_not_met() {
        // Two walls of a valley in cells of 77 lattice units: a ray two units beside the floor's edge meets only the wall on its own side.
        let far = 1 << 30;
        let corners = [[far + 60, -77, 0], [far, 0, 0], [far, 0, 77], [far + 60, 77, 0]];
        let surface = PatchSurface::of_drawn(&corners.map(vertex), &[DrawnVertex::default(); 4], &[[0, 1, 2], [1, 3, 2]]);
        for aside in [-2.0, 2.0] {
            let found = surface.nearest(&Ray::radial(DVec3::new(f64::from(far), aside, 10.0))).unwrap();
            assert!((found - f64::from(far) - 2.0 * 60.0 / 77.0).abs() < 1e-3, "{}", found - f64::from(far));
        }
    }

    #[test]
    fn no_ray_slips_between_the_cells_of_a_grid() {
        let (cells, far) = (16, 1 << 29);
        let position = |k: i32| IVec3::new(far + (k * 7919) % 1000, (k % 17 - 8) * 1000, (k / 17 - 8) * 1000);
        let surface = PatchSurface::new((0..17 * 17).map(position).collect(), grouped_grid(cells), 32);
        for (k, p) in surface.positions.iter().enumerate().filter(|(k, _)| k % 17 % 16 != 0 && (17..272).contains(k)) {
            let found = surface.nearest(&Ray::radial(p.as_dvec3())).unwrap_or_else(|| panic!("sample {k}"));
            assert!((found - p.as_dvec3().length()).abs() < 1e-5, "sample {k}");
        }
    }
}
