//! A triangle mesh with face adjacency, the structure of the classic simplifiers (Hoppe 1996; Garland and Heckbert 1997): every
//! face knows its three vertices and its three neighbour faces, every vertex one of its faces. In: a heightfield, or vertices
//! and faces. Out: connectivity that can be walked and edited in place.
//!
//! Corners run counter-clockwise seen from above, and neighbour k of a face is across the edge *opposite* corner k. Nothing
//! is ever moved in memory: removed faces and vertices keep their numbers as empty slots.

use super::validate::Violation;
use crate::decimate::mesh::Mesh;
use crate::{Heightfield, TriangleSurface};
use glam::DVec3;
use std::collections::HashMap;

/// No face and no vertex.
pub const NONE: u32 = u32::MAX;

/// Face and opposite corner of every edge, by its two ends in the direction of the face.
pub(super) type DirectedEdges = HashMap<(u32, u32), (u32, usize)>;

/// A manifold triangle mesh, with or without border.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceMesh {
    /// Positions of the vertices.
    pub positions: Vec<DVec3>,
    /// Corners of the faces, counter-clockwise. Removed faces hold [`NONE`].
    pub faces: Vec<[u32; 3]>,
    /// Neighbour k of a face is across the edge opposite its corner k; [`NONE`] at a border.
    pub neighbours: Vec<[u32; 3]>,
    /// One face of every vertex; [`NONE`] for removed vertices. A new mesh names each vertex's lowest face.
    pub face_of: Vec<u32>,
}

impl FaceMesh {
    /// The mesh of these vertices and faces.
    ///
    /// # Errors
    /// What is wrong with them, first of all that they are no manifold.
    pub fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<FaceMesh, Violation> {
        let mut face_of = vec![NONE; positions.len()];
        for (number, face) in faces.iter().enumerate() {
            if face[0] == face[1] || face[1] == face[2] || face[2] == face[0] {
                return Err(Violation::Degenerate { face: number as u32 });
            }
            for &vertex in face {
                let first = face_of.get_mut(vertex as usize).ok_or(Violation::NoSuchVertex { face: number as u32, vertex })?;
                *first = (*first).min(number as u32);
            }
        }
        if let Some(vertex) = face_of.iter().position(|&face| face == NONE) {
            return Err(Violation::Isolated { vertex: vertex as u32 });
        }
        let edges = directed_edges(&faces)?;
        let mut neighbours = vec![[NONE; 3]; faces.len()];
        for (&(from, to), &(face, corner)) in &edges {
            neighbours[face as usize][corner] = edges.get(&(to, from)).map_or(NONE, |&(other, _)| other);
        }
        let mesh = FaceMesh { positions, faces, neighbours, face_of };
        mesh.validate()?;
        Ok(mesh)
    }

    /// The full mesh of a heightfield: the triangles of [`Mesh::grid`], vertex numbers as its samples'.
    pub fn from_heightfield(field: &Heightfield) -> FaceMesh {
        // Rows run south in samples and north in space, which turns triangles around.
        let faces = Mesh::grid(field.columns(), field.rows()).faces().map(|[a, b, c]| [a, c, b]).collect();
        let positions: Vec<DVec3> = (0..field.heights().len()).map(|sample| field.position(sample)).collect();
        FaceMesh::new(positions, faces).expect("a grid is a manifold")
    }

    /// Faces that are there.
    pub fn living_faces(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.faces.len() as u32).filter(|&face| self.faces[face as usize][0] != NONE)
    }

    /// Vertices that are there.
    pub fn living_vertices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.face_of.len() as u32).filter(|&vertex| self.face_of[vertex as usize] != NONE)
    }

    /// Which corner of `face` is at `vertex`; none of those of [`NONE`].
    pub fn corner_in(&self, face: u32, vertex: u32) -> Option<usize> {
        self.faces.get(face as usize)?.iter().position(|&v| v == vertex)
    }

    /// The face after `face` counter-clockwise around the vertex of its corner `corner`, or [`NONE`].
    pub fn counter_clockwise(&self, face: u32, corner: usize) -> u32 {
        self.neighbours[face as usize][(corner + 1) % 3]
    }

    /// The face after `face` clockwise around the vertex of its corner `corner`, or [`NONE`].
    pub fn clockwise(&self, face: u32, corner: usize) -> u32 {
        self.neighbours[face as usize][(corner + 2) % 3]
    }

    /// The faces around a vertex with its corner in each, counter-clockwise; at a border they begin at its clockwise end.
    pub fn star(&self, vertex: u32) -> Star<'_> {
        let mut first = self.face_of[vertex as usize];
        let start = first;
        while let Some(corner) = self.corner_in(first, vertex) {
            let before = self.clockwise(first, corner);
            if before == NONE || before == start {
                break;
            }
            first = before;
        }
        Star { mesh: self, vertex, first, at: first }
    }

    /// Fills `ring` with the neighbours of a vertex, counter-clockwise; true if they close a loop, false at a border.
    pub fn ring(&self, vertex: u32, ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let mut closed = false;
        let mut last = NONE;
        for (face, corner) in self.star(vertex) {
            ring.push(self.faces[face as usize][(corner + 1) % 3]);
            last = self.faces[face as usize][(corner + 2) % 3];
            closed = self.counter_clockwise(face, corner) != NONE;
        }
        if !closed && last != NONE {
            ring.push(last);
        }
        closed
    }

    /// The face to the left of the edge from `a` to `b`: the one whose corners hold b right after a.
    pub fn left_of(&self, a: u32, b: u32) -> Option<u32> {
        self.star(a).find(|&(face, corner)| self.faces[face as usize][(corner + 1) % 3] == b).map(|(face, _)| face)
    }

    /// Vertices and faces that are there, numbered anew.
    pub fn surface(&self) -> TriangleSurface {
        let mut number = vec![NONE; self.positions.len()];
        let mut positions = Vec::new();
        for vertex in self.living_vertices() {
            number[vertex as usize] = positions.len() as u32;
            positions.push(self.positions[vertex as usize]);
        }
        let faces = self.living_faces().map(|face| self.faces[face as usize].map(|v| number[v as usize])).collect();
        TriangleSurface { positions, faces }
    }
}

/// Every directed edge with its face and the corner opposite it; removed faces have none.
///
/// # Errors
/// If two faces run along one edge in one direction.
pub(super) fn directed_edges(faces: &[[u32; 3]]) -> Result<DirectedEdges, Violation> {
    let mut sides = HashMap::with_capacity(3 * faces.len());
    for (number, face) in faces.iter().enumerate().filter(|(_, face)| face[0] != NONE) {
        for corner in 0..3 {
            let (from, to) = (face[(corner + 1) % 3], face[(corner + 2) % 3]);
            if let Some((other, _)) = sides.insert((from, to), (number as u32, corner)) {
                return Err(Violation::EdgeTwice { faces: [other, number as u32], edge: [from, to] });
            }
        }
    }
    Ok(sides)
}

/// Iterator over the faces around a vertex.
pub struct Star<'a> {
    mesh: &'a FaceMesh,
    vertex: u32,
    first: u32,
    at: u32,
}

impl Iterator for Star<'_> {
    type Item = (u32, usize);

    fn next(&mut self) -> Option<(u32, usize)> {
        let face = self.at;
        let corner = self.mesh.corner_in(face, self.vertex)?;
        let following = self.mesh.counter_clockwise(face, corner);
        self.at = if following == self.first { NONE } else { following };
        Some((face, corner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(columns: usize, rows: usize) -> FaceMesh {
        FaceMesh::from_heightfield(&Heightfield::new(columns, rows, vec![0.0; columns * rows]).unwrap())
    }

    #[test]
    fn grids_of_any_shape_are_valid_and_counter_clockwise() {
        for (columns, rows) in [(2, 2), (2, 5), (5, 2), (4, 3), (7, 7)] {
            let mesh = flat(columns, rows);
            assert_eq!(mesh.faces.len(), 2 * (columns - 1) * (rows - 1));
            for face in &mesh.faces {
                let [a, b, c] = face.map(|v| mesh.positions[v as usize].truncate());
                assert_eq!((b - a).perp_dot(c - a), 1.0);
            }
        }
    }

    #[test]
    fn rings_are_counter_clockwise_closed_inside_and_open_at_borders() {
        let mesh = flat(4, 4);
        let mut ring = Vec::new();
        for vertex in 0..16u32 {
            let inside = (1..3).contains(&(vertex % 4)) && (1..3).contains(&(vertex / 4));
            assert_eq!(mesh.ring(vertex, &mut ring), inside, "vertex {vertex}");
            assert_eq!(ring.len(), mesh.star(vertex).count() + usize::from(!inside));
            let spoke = |v: u32| mesh.positions[v as usize].truncate() - mesh.positions[vertex as usize].truncate();
            assert!(ring.windows(2).all(|pair| spoke(pair[0]).perp_dot(spoke(pair[1])) > 0.0), "vertex {vertex}: {ring:?}");
        }
        // The north-west corner: south, perhaps south-east, east.
        mesh.ring(0, &mut ring);
        assert_eq!((ring[0], ring[ring.len() - 1]), (4, 1));
    }

    #[test]
    fn left_of_an_edge_is_the_face_that_runs_along_it() {
        let mesh = flat(3, 3);
        for (number, face) in mesh.faces.iter().enumerate() {
            for k in 0..3 {
                assert_eq!(mesh.left_of(face[k], face[(k + 1) % 3]), Some(number as u32));
            }
        }
        assert_eq!(mesh.left_of(0, 1), None, "beyond the northern border");
        assert_eq!(mesh.left_of(0, 8), None, "no edge");
    }
}
