//! Whole surfaces: directed edges keyed by exact lattice positions must cancel, triangles must face outwards.

use crate::lattice::orientation;
use crate::layout::PatchVertex;
use glam::IVec3;
use std::collections::HashMap;

/// Faults of one surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceReport {
    /// Triangles seen.
    pub triangles: usize,
    /// Directed edges that no opposite edge cancels.
    pub cracks: usize,
    /// Triangles turned to the inside of the planet.
    pub flipped: usize,
    /// Triangles without area: equal corners, or corners in one plane with the planet's centre.
    pub degenerate: usize,
}

/// Collects the triangles of all patches of a surface.
#[derive(Default)]
pub struct SurfaceCheck {
    open_edges: HashMap<[IVec3; 2], i32>,
    edges: Vec<(u32, u32, i32)>,
    report: SurfaceReport,
}

impl SurfaceCheck {
    /// Adds the drawn triangles of one patch.
    pub fn add(&mut self, vertices: &[PatchVertex], triangles: &[[u32; 3]]) {
        self.edges.clear();
        self.report.triangles += triangles.len();
        for &[a, b, c] in triangles {
            let [pa, pb, pc] = [a, b, c].map(|v| IVec3::from_array(vertices[v as usize].position));
            match orientation(pa, pb, pc) {
                0 => self.report.degenerate += 1,
                -1 => self.report.flipped += 1,
                _ => {}
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                self.edges.push((from.min(to), from.max(to), if from < to { 1 } else { -1 }));
            }
        }
        self.edges.sort_unstable();
        // Edges between two triangles of one patch cancel here; what is left is the patch's rim (or a fault).
        for run in self.edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let sum: i32 = run.iter().map(|e| e.2).sum();
            if sum != 0 {
                let [p, q] = [run[0].0, run[0].1].map(|v| IVec3::from_array(vertices[v as usize].position));
                let (key, sign) = if p.to_array() <= q.to_array() { ([p, q], 1) } else { ([q, p], -1) };
                *self.open_edges.entry(key).or_insert(0) += sign * sum;
            }
        }
    }

    /// What is known before the last patch is added: everything but the cracks.
    pub fn so_far(&self) -> SurfaceReport {
        self.report
    }

    /// The faults of everything added.
    pub fn finish(mut self) -> SurfaceReport {
        self.report.cracks = self.open_edges.values().map(|n| n.unsigned_abs() as usize).sum();
        self.report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> (Vec<PatchVertex>, Vec<[u32; 3]>) {
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let vertices = corners.map(|p| PatchVertex { position: p.map(|c: i32| c * 1000), ..Default::default() }).to_vec();
        (vertices, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    }

    fn report(vertices: &[PatchVertex], triangles: &[[u32; 3]]) -> SurfaceReport {
        let mut check = SurfaceCheck::default();
        check.add(vertices, triangles);
        check.finish()
    }

    #[test]
    fn a_closed_surface_has_no_faults() {
        let (vertices, triangles) = tetrahedron();
        assert_eq!(report(&vertices, &triangles), SurfaceReport { triangles: 4, ..Default::default() });
    }

    #[test]
    fn holes_shifted_corners_and_flips_are_found() {
        let (mut vertices, mut triangles) = tetrahedron();
        assert_eq!(report(&vertices, &triangles[1..]).cracks, 3);
        triangles[0].swap(0, 1);
        let flipped = report(&vertices, &triangles);
        assert_eq!((flipped.flipped, flipped.cracks), (1, 6));
        let (_, triangles) = tetrahedron();
        vertices.push(vertices[2]);
        vertices[4].position[0] += 1;
        let mut split = triangles.clone();
        split[0] = [0, 1, 4];
        assert!(report(&vertices, &split).cracks > 0);
        split[0] = [0, 1, 1];
        assert_eq!(report(&vertices, &split).degenerate, 1);
    }

    #[test]
    fn equal_positions_join_different_patches() {
        let (vertices, triangles) = tetrahedron();
        let mut check = SurfaceCheck::default();
        check.add(&vertices, &triangles[..2]);
        let mut reversed = vertices.clone();
        reversed.reverse();
        check.add(&reversed, &triangles[2..].iter().map(|t| t.map(|v| 3 - v)).collect::<Vec<_>>());
        assert_eq!(check.finish().cracks, 0);
    }
}
