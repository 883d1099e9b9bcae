//! Whole surfaces: directed edges keyed by the exact positions of their ends must cancel, triangles must face outwards.
//!
//! The key of a vertex is its lattice position together with the bits of its drawn position: an edge cancels only against
//! one that has both in common.

use crate::draw::layout::{DrawnVertex, PatchVertex};
use crate::draw::view::View;
use crate::globe::lattice::{determinant, orientation};
use glam::{DVec3, IVec3};
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
    /// Triangles without area: equal corners, or corners in one plane with the planet's centre. Not those of a vertex that has only
    /// just left its parent's position.
    pub degenerate: usize,
}

/// What tells a vertex of the surface from others: its lattice position, and the bits of its camera-relative drawn position.
type Key = ([i32; 3], [u32; 3]);

/// Collects the triangles of all patches of a surface.
#[derive(Default)]
pub struct SurfaceCheck {
    open_edges: HashMap<[Key; 2], i32>,
    edges: Vec<(u32, u32, i32)>,
    report: SurfaceReport,
}

impl SurfaceCheck {
    /// Adds the drawn triangles of one patch. `drawn_positions` holds as many vertices as triangles use.
    pub fn add(&mut self, vertices: &[PatchVertex], drawn_positions: &[DrawnVertex], triangles: &[[u32; 3]]) {
        self.edges.clear();
        self.report.triangles += triangles.len();
        for &[a, b, c] in triangles {
            let slides = [a, b, c].iter().any(|&v| drawn_positions[v as usize].weight > 0.0);
            match drawn_orientation([a, b, c].map(|v| Slide::new(vertices, drawn_positions, v))) {
                0 if !slides => self.report.degenerate += 1,
                -1 => self.report.flipped += 1,
                _ => {}
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                self.edges.push((from.min(to), from.max(to), if from < to { 1 } else { -1 }));
            }
        }
        self.edges.sort_unstable();
        let key = |v: u32| {
            let drawn = &drawn_positions[v as usize];
            (vertices[v as usize].position, drawn.position.map(f32::to_bits))
        };
        // Edges between two triangles of one patch cancel here; what is left is the patch's rim (or a fault).
        for run in self.edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let sum: i32 = run.iter().map(|e| e.2).sum();
            if sum != 0 {
                let [p, q] = [run[0].0, run[0].1].map(key);
                let (edge, sign) = if p <= q { ([p, q], 1) } else { ([q, p], -1) };
                *self.open_edges.entry(edge).or_insert(0) += sign * sum;
            }
        }
    }

    /// What is known before the last patch is added: everything but the cracks.
    pub fn so_far(&self) -> SurfaceReport {
        self.report
    }

    /// The faults of everything added.
    pub fn finish(self) -> SurfaceReport {
        self.finish_where(|_| true)
    }

    /// The faults of everything added, where only what is in sight of a view was: behind its outline nothing need cancel. `ground` is the
    /// radius in lattice units of a ball that hides what is behind it.
    pub fn finish_in_sight(self, view: &View, ground: f64) -> SurfaceReport {
        self.finish_where(|edge| {
            let [p, q] = edge.map(|(_, drawn)| DVec3::from_array(drawn.map(|bits| f64::from(f32::from_bits(bits)))));
            let outside = view.planes.iter().any(|plane| plane.dot(p) > 0.0 && plane.dot(q) > 0.0);
            let hidden = view.horizon && [p, q].into_iter().all(|end| is_hidden(view.eye, end, ground));
            !outside && !hidden
        })
    }

    fn finish_where(mut self, counts: impl Fn([Key; 2]) -> bool) -> SurfaceReport {
        let open = self.open_edges.iter().filter(|(edge, n)| **n != 0 && counts(**edge));
        self.report.cracks = open.map(|(_, n)| n.unsigned_abs() as usize).sum();
        self.report
    }
}

/// Whether a point, as seen from an eye outside the ball, is behind the ball; inside of it, whether the ground there faces away.
fn is_hidden(eye: DVec3, from_eye: DVec3, ball: f64) -> bool {
    let (point, beyond) = (eye + from_eye, eye.length() > ball);
    if point.length() <= ball {
        return beyond && eye.dot(point) < point.length_squared();
    }
    let nearest = (-eye.dot(from_eye) / from_eye.length_squared()).clamp(0.0, 1.0);
    beyond && (eye + from_eye * nearest).length() < ball
}

/// A vertex on the straight way from its own position to its parent's.
#[derive(Clone, Copy)]
struct Slide {
    own: IVec3,
    parent: IVec3,
    weight: f64,
}

impl Slide {
    fn new(vertices: &[PatchVertex], drawn_positions: &[DrawnVertex], v: u32) -> Slide {
        let vertex = &vertices[v as usize];
        let parent = vertices[vertex.parent() as usize].position;
        let weight = f64::from(drawn_positions[v as usize].weight);
        Slide { own: IVec3::from_array(vertex.position), parent: IVec3::from_array(parent), weight }
    }

    /// The ends of the way that it is not past, with their shares.
    fn ends(self) -> impl Iterator<Item = (IVec3, f64)> + Clone {
        [(self.own, 1.0 - self.weight), (self.parent, self.weight)].into_iter().filter(|end| end.1 > 0.0)
    }
}

/// Sign of the determinant of three drawn positions before they are rounded to f32. It is linear in each of them: the sum of the
/// exact determinants at the ends of the ways, in f64. Where they all have one sign, so has the sum; else it is right to within
/// 2⁻⁵⁰ of its largest part.
fn drawn_orientation([a, b, c]: [Slide; 3]) -> i32 {
    if a.weight == 0.0 && b.weight == 0.0 && c.weight == 0.0 {
        return orientation(a.own, b.own, c.own);
    }
    let mut sum = 0.0;
    for (p, u) in a.ends() {
        for (q, v) in b.ends() {
            for (r, w) in c.ends() {
                sum += u * v * w * determinant(p, q, r) as f64;
            }
        }
    }
    if sum > 0.0 {
        1
    } else if sum < 0.0 {
        -1
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::layout::FrameView;
    use crate::reference::position::drawn_position;

    fn tetrahedron() -> (Vec<PatchVertex>, Vec<[u32; 3]>) {
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let vertices = corners.map(|p| PatchVertex { position: p.map(|c: i32| c * 1000), ..Default::default() }).to_vec();
        (vertices, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    }

    fn in_own_position(vertices: &[PatchVertex]) -> Vec<DrawnVertex> {
        let own = |v: u32| drawn_position(&FrameView::default(), vertices, v, 0.0).to_array();
        (0..vertices.len() as u32).map(|v| DrawnVertex { position: own(v), weight: 0.0 }).collect()
    }

    fn report(vertices: &[PatchVertex], triangles: &[[u32; 3]]) -> SurfaceReport {
        let mut check = SurfaceCheck::default();
        check.add(vertices, &in_own_position(vertices), triangles);
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
        check.add(&vertices, &in_own_position(&vertices), &triangles[..2]);
        let mut reversed = vertices.clone();
        reversed.reverse();
        check.add(&reversed, &in_own_position(&reversed), &triangles[2..].iter().map(|t| t.map(|v| 3 - v)).collect::<Vec<_>>());
        assert_eq!(check.finish().cracks, 0);
    }

    /// Drawn positions of vertices of which the last morphs to the first by `weight`.
    fn drawn_positions(vertices: &[PatchVertex], weight: f32) -> Vec<DrawnVertex> {
        let weights = [0.0, 0.0, 0.0, weight];
        let drawn = |v: usize| drawn_position(&FrameView::default(), vertices, v as u32, weights[v]).to_array();
        (0..4).map(|v| DrawnVertex { position: drawn(v), weight: weights[v] }).collect()
    }

    /// The tetrahedron in two patches, whose vertex 3 morphs to vertex 0 by a weight for each patch.
    fn sliding(weights: [f32; 2]) -> SurfaceReport {
        let (vertices, triangles) = tetrahedron();
        let mut check = SurfaceCheck::default();
        for (weight, half) in weights.into_iter().zip(triangles.chunks(2)) {
            check.add(&vertices, &drawn_positions(&vertices, weight), half);
        }
        check.finish()
    }

    #[test]
    fn a_vertex_with_two_drawn_positions_is_a_crack() {
        for weight in [0.0, 0.25] {
            assert_eq!(sliding([weight; 2]), SurfaceReport { triangles: 4, ..Default::default() }, "{weight}");
        }
        let arrived = sliding([1.0; 2]);
        assert_eq!((arrived.cracks, arrived.degenerate), (0, 0), "a vertex in its parent's position tears nothing");
        assert!(sliding([0.25, 0.25 + f32::EPSILON]).cracks > 0);
    }

    #[test]
    fn triangles_that_a_geomorph_turns_over_are_flipped() {
        let (mut vertices, triangles) = tetrahedron();
        // Beyond the plane of the opposite triangle.
        vertices[0].position = [-3000; 3];
        let mut check = SurfaceCheck::default();
        check.add(&vertices, &drawn_positions(&vertices, 0.5), &triangles);
        assert!(check.finish().flipped > 0);
    }
}
