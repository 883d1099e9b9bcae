//! What must hold in a mesh with face adjacency, checked from scratch. In: a mesh. Out: the first invariant that it violates.

use super::mesh::{directed_edges, DirectedEdges, FaceMesh, NONE};

/// What is wrong with a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Violation {
    /// A corner names a vertex that is not there.
    #[error("face {face} has a corner at vertex {vertex}, which is not there")]
    NoSuchVertex {
        /// The face.
        face: u32,
        /// What it names.
        vertex: u32,
    },
    /// Two corners of a face are one vertex.
    #[error("face {face} has two corners at one vertex")]
    Degenerate {
        /// The face.
        face: u32,
    },
    /// Two faces run along one edge in one direction: more than two faces meet there, or one of them is turned over.
    #[error(
        "faces {} and {} both run from vertex {} to vertex {}: the surface is no manifold there, or one of them is turned over",
        faces[0], faces[1], edge[0], edge[1]
    )]
    EdgeTwice {
        /// The faces.
        faces: [u32; 2],
        /// From which vertex to which.
        edge: [u32; 2],
    },
    /// A neighbour does not lie across the edge that it is named for, or does not name the face back.
    #[error("face {face} names {neighbour} as its neighbour {side}, which does not have that edge the other way or denies it")]
    Neighbour {
        /// The face.
        face: u32,
        /// Number of the side: that opposite this corner.
        side: usize,
        /// The face that it names.
        neighbour: u32,
    },
    /// Two faces share an edge and do not know of each other.
    #[error("face {face} has a border at its side {side}, although another face has that edge the other way")]
    Unlinked {
        /// The face.
        face: u32,
        /// Number of the side: that opposite this corner.
        side: usize,
    },
    /// The face of a vertex does not have it as a corner.
    #[error("vertex {vertex} names face {face}, which has no corner there")]
    FaceOfVertex {
        /// The vertex.
        vertex: u32,
        /// The face that it names.
        face: u32,
    },
    /// A vertex has no face.
    #[error("no face has a corner at vertex {vertex}")]
    Isolated {
        /// The vertex.
        vertex: u32,
    },
    /// The faces of a vertex are not one fan.
    #[error("vertex {vertex} has {faces} faces but only {connected} can be reached around it: several sheets meet in it")]
    Vertex {
        /// The vertex.
        vertex: u32,
        /// Faces with a corner there.
        faces: usize,
        /// Faces reached from its own.
        connected: usize,
    },
}

/// Living vertices - edges + faces: 1 for a disc, 2 for a sphere.
pub fn euler_characteristic(mesh: &FaceMesh) -> i64 {
    let faces = mesh.living_faces().count() as i64;
    let borders = mesh.living_faces().flat_map(|f| mesh.neighbours[f as usize]).filter(|&n| n == NONE).count() as i64;
    let edges = (3 * faces + borders) / 2;
    mesh.living_vertices().count() as i64 - edges + faces
}

impl FaceMesh {
    /// Checks every invariant but the number of sheets and holes, which is [`euler_characteristic`]'s.
    ///
    /// # Errors
    /// The first violation, in the order of [`Violation`].
    pub fn validate(&self) -> Result<(), Violation> {
        let mut faces_at = vec![0; self.positions.len()];
        for face in self.living_faces() {
            self.check_corners(face, &mut faces_at)?;
        }
        let directed = directed_edges(&self.faces)?;
        for face in self.living_faces() {
            (0..3).try_for_each(|side| self.check_side(face, side, &directed))?;
        }
        (0..self.face_of.len() as u32).try_for_each(|vertex| self.check_vertex(vertex, faces_at[vertex as usize]))
    }

    /// The edge opposite a corner, in the direction of its face.
    fn side(&self, face: u32, side: usize) -> (u32, u32) {
        let corners = self.faces[face as usize];
        (corners[(side + 1) % 3], corners[(side + 2) % 3])
    }

    fn check_corners(&self, face: u32, faces_at: &mut [usize]) -> Result<(), Violation> {
        let corners @ [a, b, c] = self.faces[face as usize];
        for vertex in corners {
            *faces_at.get_mut(vertex as usize).ok_or(Violation::NoSuchVertex { face, vertex })? += 1;
            if self.face_of[vertex as usize] == NONE {
                return Err(Violation::NoSuchVertex { face, vertex });
            }
        }
        if a == b || b == c || c == a {
            return Err(Violation::Degenerate { face });
        }
        Ok(())
    }

    fn check_side(&self, face: u32, side: usize, directed: &DirectedEdges) -> Result<(), Violation> {
        let (from, to) = self.side(face, side);
        let neighbour = self.neighbours[face as usize][side];
        if neighbour == NONE {
            return if directed.contains_key(&(to, from)) { Err(Violation::Unlinked { face, side }) } else { Ok(()) };
        }
        let exists = (neighbour as usize) < self.faces.len();
        let answers = |k: usize| self.side(neighbour, k) == (to, from) && self.neighbours[neighbour as usize][k] == face;
        if exists && (0..3).any(answers) {
            Ok(())
        } else {
            Err(Violation::Neighbour { face, side, neighbour })
        }
    }

    fn check_vertex(&self, vertex: u32, faces: usize) -> Result<(), Violation> {
        let face = self.face_of[vertex as usize];
        if face == NONE {
            return Ok(());
        }
        if faces == 0 {
            return Err(Violation::Isolated { vertex });
        }
        if self.faces.get(face as usize).is_none_or(|corners| !corners.contains(&vertex)) {
            return Err(Violation::FaceOfVertex { vertex, face });
        }
        let connected = self.star(vertex).count();
        if connected == faces {
            Ok(())
        } else {
            Err(Violation::Vertex { vertex, faces, connected })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Heightfield;
    use glam::DVec3;

    fn grid() -> FaceMesh {
        FaceMesh::from_heightfield(&Heightfield::new(4, 4, vec![0.0; 16]).unwrap())
    }

    fn build(vertices: usize, faces: &[[u32; 3]]) -> Result<FaceMesh, Violation> {
        FaceMesh::new(vec![DVec3::ZERO; vertices], faces.to_vec())
    }

    #[test]
    fn input_that_is_no_manifold_is_refused_by_name() {
        assert_eq!(build(3, &[[0, 1, 3]]), Err(Violation::NoSuchVertex { face: 0, vertex: 3 }));
        assert_eq!(build(3, &[[0, 1, 0]]), Err(Violation::Degenerate { face: 0 }));
        assert_eq!(build(4, &[[0, 1, 2]]), Err(Violation::Isolated { vertex: 3 }));
        let turned_over = build(4, &[[0, 1, 2], [0, 1, 3]]);
        assert_eq!(turned_over, Err(Violation::EdgeTwice { faces: [0, 1], edge: [0, 1] }));
        let three_on_an_edge = build(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(three_on_an_edge, Err(Violation::EdgeTwice { faces: [0, 2], edge: [0, 1] }));
        let bow_tie = build(5, &[[0, 1, 2], [0, 3, 4]]);
        assert_eq!(bow_tie, Err(Violation::Vertex { vertex: 0, faces: 2, connected: 1 }));
        assert!(build(4, &[[0, 1, 2], [1, 0, 3]]).is_ok());
    }

    #[test]
    fn every_broken_link_is_found() {
        assert_eq!(grid().validate(), Ok(()));
        let broken = |damage: fn(&mut FaceMesh)| {
            let mut mesh = grid();
            damage(&mut mesh);
            mesh.validate().unwrap_err()
        };
        let side = 2;
        assert_ne!(grid().neighbours[4][side], NONE);
        assert_eq!(broken(|mesh| mesh.neighbours[4][2] = NONE), Violation::Unlinked { face: 4, side });
        assert!(matches!(broken(|mesh| mesh.neighbours[4][2] = 17), Violation::Neighbour { face: 4, neighbour: 17, .. }));
        assert!(matches!(broken(|mesh| mesh.neighbours[4][2] = 99), Violation::Neighbour { face: 4, neighbour: 99, .. }));
        assert!(matches!(broken(|mesh| mesh.faces[4].swap(0, 1)), Violation::EdgeTwice { .. }));
        assert_eq!(broken(|mesh| mesh.face_of[5] = 17), Violation::FaceOfVertex { vertex: 5, face: 17 });
        assert!(matches!(broken(|mesh| mesh.face_of[5] = NONE), Violation::NoSuchVertex { vertex: 5, .. }));
        assert!(matches!(broken(|mesh| mesh.faces[4] = [NONE; 3]), Violation::Neighbour { neighbour: 4, .. }));
    }

    #[test]
    fn a_disc_a_ring_and_a_sphere_are_told_apart() {
        assert_eq!(euler_characteristic(&grid()), 1);
        let tetrahedron = build(4, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        assert_eq!(euler_characteristic(&tetrahedron), 2);
        let ring = build(6, &[[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]).unwrap();
        assert_eq!(euler_characteristic(&ring), 0);
    }
}
