//! Anchor springs (after Sklyar): every vertex hangs on springs to its *anchors*, the original vertices that were merged into
//! it, and a collapse costs the energy of the springs that then pull on one vertex. In: the full mesh. Out: costs and positions
//! of mergers along their edge.
//!
//! The energy at p, Σ w |p − a|², is W |p|² − 2 p·Σ w a + Σ w |a|²: three sums, which add up when vertices merge, so that no
//! list of anchors is kept and a collapse takes constant time however many there are.
//!
//! Springs are weighted by the squared curvature of the ground. A vertex whose anchors spread over a radius R gathers an
//! energy of about w R⁴ and errs by about (curvature) R² in height: with w = curvature², equal energy means equal error.

use super::cost::{Candidate, CollapseCost};
use super::mesh::FaceMesh;
use super::outline::{Outline, Room};
use glam::{DVec2, DVec3};

/// Springs on flat ground, as a share of the mean spring: what keeps flat triangles in shape.
const FLAT_SHARE: f64 = 0.02;

/// How much heavier springs to anchors on the outline are: nothing but them shows when it drifts.
const BORDER_WEIGHT: f64 = 4.0;

/// All springs of one vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Springs {
    /// Σ w.
    weight: f64,
    /// Σ w a.
    pull: DVec3,
    /// Σ w |a|².
    square: f64,
}

impl Springs {
    fn to_anchor(anchor: DVec3, weight: f64) -> Springs {
        Springs { weight, pull: anchor * weight, square: anchor.length_squared() * weight }
    }

    fn and(self, other: Springs) -> Springs {
        Springs { weight: self.weight + other.weight, pull: self.pull + other.pull, square: self.square + other.square }
    }

    /// Energy of the springs if the vertex is at `position`.
    fn energy(&self, position: DVec3) -> f64 {
        // Rounding may leave a tiny negative number.
        (self.weight * position.length_squared() - 2.0 * position.dot(self.pull) + self.square).max(0.0)
    }

    /// How far from a to b the energy is least.
    fn rest_between(&self, [a, b]: [DVec3; 2]) -> f64 {
        let edge = b - a;
        ((self.pull - a * self.weight).dot(edge) / (self.weight * edge.length_squared())).clamp(0.0, 1.0)
    }
}

/// Springs of all vertices.
pub(super) struct AnchorSprings {
    of_vertex: Vec<Springs>,
}

impl AnchorSprings {
    /// One spring for every vertex of the full mesh, to where it is.
    pub(super) fn new(mesh: &FaceMesh, outline: &Outline) -> AnchorSprings {
        let vertices = 0..mesh.positions.len() as u32;
        let curvatures: Vec<f64> = vertices.clone().map(|v| squared_curvature(mesh, v)).collect();
        let mean = curvatures.iter().sum::<f64>() / curvatures.len() as f64;
        let spring = |vertex: u32| {
            // Level ground everywhere has no curvature to compare with.
            let weight = if mean > 0.0 { FLAT_SHARE + curvatures[vertex as usize] / mean } else { 1.0 };
            let border = if outline.pins(vertex).on_outline() { BORDER_WEIGHT } else { 1.0 };
            Springs::to_anchor(mesh.positions[vertex as usize], weight * border)
        };
        AnchorSprings { of_vertex: vertices.map(spring).collect() }
    }
}

/// How much the slopes of the faces around a vertex differ: their mean squared distance from the mean slope. On a smooth
/// surface, that is the square of its second derivatives, saddles included.
fn squared_curvature(mesh: &FaceMesh, vertex: u32) -> f64 {
    let slopes = mesh.star(vertex).map(|(face, _)| slope(mesh.faces[face as usize].map(|v| mesh.positions[v as usize])));
    let (mut count, mut sum, mut squares) = (0.0, DVec2::ZERO, 0.0);
    for slope in slopes {
        (count, sum, squares) = (count + 1.0, sum + slope, squares + slope.length_squared());
    }
    (squares / count - (sum / count).length_squared()).max(0.0)
}

/// Gradient of the plane through three points, not all above one line.
fn slope([a, b, c]: [DVec3; 3]) -> DVec2 {
    let normal = (b - a).cross(c - a);
    -normal.truncate() / normal.z
}

impl CollapseCost for AnchorSprings {
    fn candidates(&self, ends: [u32; 2], positions: [DVec3; 2], room: Room) -> Vec<Candidate> {
        let [a, b] = ends.map(|v| self.of_vertex[v as usize]);
        let springs = a.and(b);
        let tried = room.choose(positions, &[0.0, 1.0, 0.5, springs.rest_between(positions)]);
        tried.into_iter().map(|position| Candidate { cost: springs.energy(position), position }).collect()
    }

    fn merge(&mut self, vertex: u32, other: u32) {
        let gone = self.of_vertex[other as usize];
        self.of_vertex[vertex as usize] = self.of_vertex[vertex as usize].and(gone);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Heightfield;

    #[test]
    fn the_three_sums_are_the_sum_over_all_anchors() {
        let anchors = [(1.0, 2.0, 3.0, 0.5), (4.0, -1.0, 0.0, 2.0), (-2.0, 2.5, 1.0, 1.25)];
        let anchors = anchors.map(|(x, y, z, w)| (DVec3::new(x, y, z), w));
        let springs = anchors.iter().fold(Springs::default(), |sum, &(a, w)| sum.and(Springs::to_anchor(a, w)));
        for position in [DVec3::ZERO, DVec3::new(0.3, 7.0, -2.0)] {
            let one_by_one: f64 = anchors.iter().map(|&(a, w)| w * position.distance_squared(a)).sum();
            assert!((springs.energy(position) - one_by_one).abs() < 1e-10);
        }
    }

    #[test]
    fn springs_come_to_rest_where_their_energy_is_least() {
        let ends = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(3.0, 0.0, 1.0)];
        let springs = Springs::to_anchor(ends[0], 3.0).and(Springs::to_anchor(ends[1], 1.0));
        assert!((springs.rest_between(ends) - 0.25).abs() < 1e-12);
        let energy = |share: f64| springs.energy(ends[0].lerp(ends[1], share));
        assert!(energy(0.25) < energy(0.26) && energy(0.25) < energy(0.24));
        assert_eq!(Springs::to_anchor(DVec3::new(-9.0, 0.0, 0.0), 1.0).rest_between(ends), 0.0);
    }

    #[test]
    fn springs_are_heavy_at_features_and_borders() {
        let mut heights = vec![0.0; 49];
        heights[24] = 5.0;
        let field = Heightfield::new(7, 7, heights).unwrap();
        let springs = AnchorSprings::new(&FaceMesh::from_heightfield(&field), &Outline::of(&field));
        let weight = |v: usize| springs.of_vertex[v].weight;
        assert!(weight(24) > 10.0 * weight(8) && weight(3) == BORDER_WEIGHT * weight(8), "{} {}", weight(24), weight(8));
    }
}
