//! Quadric error metrics (Garland and Heckbert, "Surface simplification using quadric error metrics", 1997): every vertex
//! holds the sum of the squared distances to the planes of the faces that were merged into it. In: the full mesh. Out: costs
//! and positions of mergers; the best position solves three linear equations.

use super::cost::{Candidate, CollapseCost};
use super::mesh::{FaceMesh, NONE};
use super::outline::Room;
use glam::{DMat3, DVec3};
use std::ops::{Add, AddAssign};

/// Weight of the planes that hold a border where it is, for each unit of its edges' squared lengths.
const BORDER_WEIGHT: f64 = 10.0;

/// Determinants below this share of the cubed trace are those of (almost) parallel planes: no position is best.
const LEAST_DETERMINANT: f64 = 1e-9;

/// A sum of weighted squared distances to planes: pᵀ A p + 2 b·p + c.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// No planes. (The default matrix is not this one, but the identity.)
    const ZERO: Quadric = Quadric { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    /// Weighted squared distance to the plane through `point` with unit normal `normal`.
    fn of_plane(normal: DVec3, point: DVec3, weight: f64) -> Quadric {
        let offset = -normal.dot(point);
        let a = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        Quadric { a: a * weight, b: normal * (offset * weight), c: offset * offset * weight }
    }

    /// The sum at a position.
    fn at(&self, position: DVec3) -> f64 {
        // Rounding may leave a tiny negative number.
        (position.dot(self.a * position) + 2.0 * self.b.dot(position) + self.c).max(0.0)
    }

    /// The position in `room` with the least sum, if there is just one.
    fn minimum(&self, room: Room) -> Option<DVec3> {
        let Room::Along(line, pins) = room else { return None };
        let scale = (self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z) / 3.0;
        let mut rows = self.a.transpose();
        let mut right = -self.b;
        // The equation of a pinned coordinate gives way to its value, scaled like the rest.
        if pins.x() {
            rows.x_axis = DVec3::X * scale;
            right.x = line.x * scale;
        }
        if pins.y() {
            rows.y_axis = DVec3::Y * scale;
            right.y = line.y * scale;
        }
        let matrix = rows.transpose();
        let solvable = matrix.determinant().abs() > LEAST_DETERMINANT * scale * scale * scale;
        solvable.then(|| room.fit(matrix.inverse() * right))
    }
}

impl Add for Quadric {
    type Output = Quadric;

    fn add(self, other: Quadric) -> Quadric {
        Quadric { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Quadric) {
        *self = *self + other;
    }
}

/// Quadrics of all vertices.
pub(super) struct Quadrics {
    of_vertex: Vec<Quadric>,
}

impl Quadrics {
    /// Quadrics of a full mesh: planes of faces weighted by area, and planes that stand on border edges.
    pub(super) fn new(mesh: &FaceMesh) -> Quadrics {
        let mut of_vertex = vec![Quadric::ZERO; mesh.positions.len()];
        for face in mesh.living_faces() {
            let corners = mesh.faces[face as usize];
            let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
            let twice = (b - a).cross(c - a);
            let normal = twice.normalize_or_zero();
            let plane = Quadric::of_plane(normal, a, twice.length() / 2.0);
            corners.into_iter().for_each(|v| of_vertex[v as usize] += plane);
            for side in (0..3).filter(|&side| mesh.neighbours[face as usize][side] == NONE) {
                let ends = [corners[(side + 1) % 3], corners[(side + 2) % 3]];
                let [from, to] = ends.map(|v| mesh.positions[v as usize]);
                let across = (to - from).cross(normal).normalize_or_zero();
                let wall = Quadric::of_plane(across, from, BORDER_WEIGHT * (to - from).length_squared());
                ends.into_iter().for_each(|v| of_vertex[v as usize] += wall);
            }
        }
        Quadrics { of_vertex }
    }
}

impl CollapseCost for Quadrics {
    fn candidates(&self, ends: [u32; 2], positions: [DVec3; 2], room: Room) -> Vec<Candidate> {
        let [a, b] = ends.map(|v| self.of_vertex[v as usize]);
        let sum = a + b;
        let mut tried = room.choose(positions, &[0.0, 1.0, 0.5]);
        tried.extend(sum.minimum(room));
        tried.into_iter().map(|position| Candidate { cost: sum.at(position), position }).collect()
    }

    fn merge(&mut self, vertex: u32, other: u32) {
        let gone = self.of_vertex[other as usize];
        self.of_vertex[vertex as usize] += gone;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::outline::Outline;
    use crate::Heightfield;

    #[test]
    fn three_planes_meet_where_the_equations_say() {
        let corner = DVec3::new(3.0, -2.0, 5.0);
        let normals = [DVec3::X, DVec3::new(0.0, 0.6, 0.8), DVec3::new(0.8, 0.0, 0.6)];
        let planes = normals.map(|normal| Quadric::of_plane(normal, corner, 2.0));
        let sum = planes[0] + planes[1] + planes[2];
        let anywhere = Room::Along(DVec3::ZERO, Default::default());
        assert!((sum.minimum(anywhere).unwrap() - corner).length() < 1e-12);
        assert!((sum.at(corner + DVec3::X) - 2.0 * (1.0 + 0.64)).abs() < 1e-12);
        assert_eq!((planes[0] + planes[1]).minimum(anywhere), None, "two planes meet along a line");
    }

    #[test]
    fn places_on_a_side_stay_on_it() {
        let field = Heightfield::new(4, 3, [0.0, 3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0, 5.0, 3.0, 5.0].to_vec()).unwrap();
        let mesh = FaceMesh::from_heightfield(&field);
        let (quadrics, outline) = (Quadrics::new(&mesh), Outline::of(&field));
        let candidates = |a: u32, b: u32| {
            let positions = [a, b].map(|v| mesh.positions[v as usize]);
            quadrics.candidates([a, b], positions, outline.room([a, b], positions).unwrap())
        };
        let along = candidates(1, 2);
        assert!(along.len() == 4 && along.iter().all(|c| c.position.y == 2.0), "{along:?}");
        let inwards = candidates(5, 1);
        assert!(inwards.len() == 2 && inwards.iter().all(|c| c.position.y == 2.0), "{inwards:?}");
        assert_eq!(candidates(1, 0).iter().map(|c| c.position).collect::<Vec<_>>(), [mesh.positions[0]]);
        assert!(candidates(5, 6).iter().any(|c| c.position.y != 1.0));
    }

    #[test]
    fn vertices_of_the_full_mesh_lie_on_all_of_their_planes() {
        let heights = (0..25).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as f32 / 64.0).collect();
        let mesh = FaceMesh::from_heightfield(&Heightfield::new(5, 5, heights).unwrap());
        let quadrics = Quadrics::new(&mesh);
        for (quadric, &position) in quadrics.of_vertex.iter().zip(&mesh.positions) {
            assert!(
                quadric.at(position) < 1e-10 && quadric.at(position + DVec3::Z) > 0.1,
                "{position}: {}",
                quadric.at(position)
            );
        }
    }

    #[test]
    fn the_best_position_costs_least() {
        let heights = (0..25).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as f32 / 64.0).collect();
        let mesh = FaceMesh::from_heightfield(&Heightfield::new(5, 5, heights).unwrap());
        let quadrics = Quadrics::new(&mesh);
        let sum = quadrics.of_vertex[12] + quadrics.of_vertex[13];
        let best = sum.minimum(Room::Along(DVec3::ZERO, Default::default())).unwrap();
        for step in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
            assert!(sum.at(best) < sum.at(best + 0.01 * step) && sum.at(best) < sum.at(best - 0.01 * step));
        }
    }
}
