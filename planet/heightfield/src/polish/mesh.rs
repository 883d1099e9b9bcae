//! The triangulation that is polished: faces with their neighbours, and the four changes it knows: flip an edge, split a face,
//! split an edge, collapse a vertex into a neighbour. In and out: a [`TriangleSurface`] over a whole rectangle.
//!
//! Half-edge `3 t + k` runs from corner k of face t to corner k + 1. Vertices stand on samples, so their positions in the plane
//! are small whole numbers and every orientation is exact; that a change turns no face around is for its caller to ask
//! beforehand.

use crate::TriangleSurface;
use glam::DVec3;

/// No half-edge, no vertex.
pub(super) const NONE: u32 = u32::MAX;

/// A face that was removed.
const DEAD: [u32; 3] = [NONE; 3];

#[derive(Clone)]
pub(super) struct Triangulation {
    pub(super) positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Of each half-edge, the one that runs the other way.
    twins: Vec<u32>,
    /// Of each vertex, some half-edge that starts there.
    leaving: Vec<u32>,
    /// Removed faces, for reuse.
    free_faces: Vec<u32>,
    /// Removed vertices, for reuse.
    free_vertices: Vec<u32>,
}

/// The next half-edge around the same face.
pub(super) fn next(edge: u32) -> u32 {
    if edge % 3 == 2 {
        edge - 2
    } else {
        edge + 1
    }
}

/// The previous half-edge around the same face.
pub(super) fn previous(edge: u32) -> u32 {
    if edge.is_multiple_of(3) {
        edge + 2
    } else {
        edge - 1
    }
}

impl Triangulation {
    pub(super) fn new(surface: TriangleSurface) -> Triangulation {
        let mut mesh = Triangulation {
            twins: twins(&surface.faces, surface.positions.len()),
            leaving: vec![NONE; surface.positions.len()],
            positions: surface.positions,
            faces: surface.faces,
            free_faces: Vec::new(),
            free_vertices: Vec::new(),
        };
        for edge in 0..mesh.twins.len() as u32 {
            let origin = mesh.origin(edge);
            mesh.leaving[origin as usize] = edge;
        }
        mesh
    }

    pub(super) fn surface(&self) -> TriangleSurface {
        let mut number = vec![NONE; self.positions.len()];
        let mut surface = TriangleSurface::default();
        for face in self.faces.iter().filter(|&&face| face != DEAD) {
            surface.faces.push(face.map(|v| {
                if number[v as usize] == NONE {
                    number[v as usize] = surface.positions.len() as u32;
                    surface.positions.push(self.positions[v as usize]);
                }
                number[v as usize]
            }));
        }
        surface
    }

    /// Faces that are there.
    pub(super) fn count(&self) -> usize {
        self.faces.len() - self.free_faces.len()
    }

    /// Room for faces: their numbers are below this.
    pub(super) fn capacity(&self) -> usize {
        self.faces.len()
    }

    pub(super) fn is_alive(&self, face: u32) -> bool {
        self.faces[face as usize] != DEAD
    }

    pub(super) fn corners(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize]
    }

    pub(super) fn triangle(&self, face: u32) -> [DVec3; 3] {
        self.positions_of(self.corners(face))
    }

    pub(super) fn positions_of(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|v| self.positions[v as usize])
    }

    /// The half-edge that runs the other way, if this one is not on the outline.
    pub(super) fn twin(&self, edge: u32) -> Option<u32> {
        let twin = self.twins[edge as usize];
        (twin != NONE).then_some(twin)
    }

    pub(super) fn origin(&self, edge: u32) -> u32 {
        self.faces[edge as usize / 3][edge as usize % 3]
    }

    /// The corner across the face from a half-edge.
    pub(super) fn apex(&self, edge: u32) -> u32 {
        self.origin(previous(edge))
    }

    /// The half-edges that leave a vertex, turning clockwise; `None` for a vertex that is gone or on the outline.
    pub(super) fn star(&self, v: u32) -> Option<Vec<u32>> {
        let start = self.leaving[v as usize];
        if start == NONE {
            return None;
        }
        let mut star = vec![start];
        loop {
            let edge = next(self.twin(star[star.len() - 1])?);
            if edge == start {
                return Some(star);
            }
            star.push(edge);
        }
    }

    /// Turns the edge between two faces around, to join their apexes.
    pub(super) fn flip(&mut self, edge: u32, twin: u32) {
        let (a, b, c, d) = (self.origin(edge), self.origin(twin), self.apex(edge), self.apex(twin));
        let outer = [previous(edge), next(twin), previous(twin), next(edge)].map(|e| self.twins[e as usize]);
        let [p, q] = [self.set(edge / 3, [c, a, d]), self.set(twin / 3, [d, b, c])];
        for (half, other) in [(p, outer[0]), (p + 1, outer[1]), (q, outer[2]), (q + 1, outer[3]), (p + 2, q + 2)] {
            self.link(half, other);
        }
    }

    /// Splits a face into three around a new vertex inside, and returns them.
    pub(super) fn split_face(&mut self, face: u32, position: DVec3) -> Vec<u32> {
        let [a, b, c] = self.corners(face);
        let [first, second, third] = [0, 1, 2].map(|k| self.twins[3 * face as usize + k]);
        let v = self.add_vertex(position);
        let p = self.set(face, [a, b, v]);
        let [q, r] = [[b, c, v], [c, a, v]].map(|corners| self.add_face(corners));
        for (half, other) in [(p, first), (q, second), (r, third), (p + 1, q + 2), (q + 1, r + 2), (r + 1, p + 2)] {
            self.link(half, other);
        }
        vec![p / 3, q / 3, r / 3]
    }

    /// Splits an edge, and the face or two beside it, at a new vertex; returns the faces there now.
    pub(super) fn split_edge(&mut self, edge: u32, position: DVec3) -> Vec<u32> {
        let v = self.add_vertex(position);
        let twin = self.twin(edge);
        let [near, far] = self.split_side(edge, v);
        let Some(twin) = twin else {
            self.link(near, NONE);
            self.link(far, NONE);
            return vec![near / 3, far / 3];
        };
        let [back_near, back_far] = self.split_side(twin, v);
        self.link(near, back_far);
        self.link(far, back_near);
        vec![near / 3, far / 3, back_near / 3, back_far / 3]
    }

    /// Splits the face of a half-edge at a vertex on it; returns the halves of that, without neighbours yet.
    fn split_side(&mut self, edge: u32, v: u32) -> [u32; 2] {
        let (a, b, c) = (self.origin(edge), self.origin(next(edge)), self.apex(edge));
        let [bc, ca] = [next(edge), previous(edge)].map(|e| self.twins[e as usize]);
        let [p, q] = [self.set(edge / 3, [a, v, c]), self.add_face([v, b, c])];
        for (half, other) in [(p + 2, ca), (q + 1, bc), (p + 1, q + 2)] {
            self.link(half, other);
        }
        [p, q]
    }

    /// Moves the start of a half-edge, whose star is given, into its end, which removes a vertex and two faces.
    pub(super) fn collapse(&mut self, edge: u32, star: &[u32]) {
        let (v, into, twin) = (self.origin(edge), self.origin(next(edge)), self.twins[edge as usize]);
        for &leaving in star {
            self.faces[leaving as usize / 3][leaving as usize % 3] = into;
        }
        let doomed = [edge / 3, twin / 3];
        for half in [edge, twin] {
            let [p, q] = [next(half), previous(half)].map(|e| self.twins[e as usize]);
            self.remove_face(half / 3);
            self.link(p, q);
            // Past the outline there is no p: its vertex leaves by the side of the face that stays.
            self.leave_by(if p == NONE { next(q) } else { p });
        }
        if let Some(&kept) = star.iter().find(|&&e| !doomed.contains(&(e / 3))) {
            self.leaving[into as usize] = kept;
        }
        self.leaving[v as usize] = NONE;
        self.free_vertices.push(v);
    }

    fn leave_by(&mut self, edge: u32) {
        let origin = self.origin(edge);
        self.leaving[origin as usize] = edge;
    }

    fn add_vertex(&mut self, position: DVec3) -> u32 {
        if let Some(v) = self.free_vertices.pop() {
            self.positions[v as usize] = position;
            return v;
        }
        self.positions.push(position);
        self.leaving.push(NONE);
        self.positions.len() as u32 - 1
    }

    fn add_face(&mut self, corners: [u32; 3]) -> u32 {
        let face = self.free_faces.pop().unwrap_or_else(|| {
            self.faces.push(DEAD);
            self.twins.extend([NONE; 3]);
            self.faces.len() as u32 - 1
        });
        self.set(face, corners)
    }

    fn remove_face(&mut self, face: u32) {
        self.faces[face as usize] = DEAD;
        self.free_faces.push(face);
    }

    /// Sets the corners of a face; returns its first half-edge.
    fn set(&mut self, face: u32, corners: [u32; 3]) -> u32 {
        self.faces[face as usize] = corners;
        for (k, v) in corners.into_iter().enumerate() {
            self.leaving[v as usize] = 3 * face + k as u32;
        }
        3 * face
    }

    fn link(&mut self, p: u32, q: u32) {
        for (from, to) in [(p, q), (q, p)] {
            if from != NONE {
                self.twins[from as usize] = to;
            }
        }
    }
}

/// Pairs half-edges: of those that leave a vertex, the one that comes back.
fn twins(faces: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let corners = faces.as_flattened();
    let mut start = vec![0u32; vertices + 1];
    corners.iter().for_each(|&v| start[v as usize + 1] += 1);
    for v in 0..vertices {
        start[v + 1] += start[v];
    }
    let mut filled = start.clone();
    let mut leaving = vec![0u32; corners.len()];
    for (edge, &v) in corners.iter().enumerate() {
        leaving[filled[v as usize] as usize] = edge as u32;
        filled[v as usize] += 1;
    }
    let target = |edge: u32| corners[next(edge) as usize];
    let back = |edge: u32| {
        let (from, to) = (corners[edge as usize], target(edge) as usize);
        leaving[start[to] as usize..start[to + 1] as usize].iter().copied().find(|&e| target(e) == from)
    };
    (0..corners.len() as u32).map(|edge| back(edge).unwrap_or(NONE)).collect()
}

/// Twice the area of a triangle in the plane, positive if counter-clockwise. Exact: its corners are on samples.
pub(super) fn doubled_area([a, b, c]: [DVec3; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Square of the longest side over [`doubled_area`]: 2 for half a cell, 10 for a side ten times as long as the height on it.
pub(super) fn aspect([a, b, c]: [DVec3; 3]) -> f64 {
    let squared = |p: DVec3, q: DVec3| (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
    squared(a, b).max(squared(b, c)).max(squared(c, a)) / doubled_area([a, b, c])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 48 cells a side, in two faces.
    fn square() -> Triangulation {
        let positions = [(0.0, 0.0), (48.0, 0.0), (48.0, 48.0), (0.0, 48.0)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        Triangulation::new(TriangleSurface { positions, faces: vec![[0, 1, 2], [0, 2, 3]] })
    }

    fn flaw(mesh: &Triangulation) -> Option<&'static str> {
        let alive: Vec<u32> = (0..mesh.capacity() as u32).filter(|&t| mesh.is_alive(t)).collect();
        for edge in alive.iter().flat_map(|t| 3 * t..3 * t + 3) {
            if let Some(twin) = mesh.twin(edge) {
                if mesh.twin(twin) != Some(edge) || mesh.origin(twin) != mesh.origin(next(edge)) {
                    return Some("twin");
                }
            }
            let leaving = mesh.leaving[mesh.origin(edge) as usize];
            if mesh.origin(leaving) != mesh.origin(edge) {
                return Some("leaving");
            }
        }
        let area: f64 = alive.iter().map(|&t| doubled_area(mesh.triangle(t))).sum();
        (area != 2.0 * 48.0 * 48.0).then_some("area")
    }

    /// The half-edge from one vertex to another.
    fn edge(mesh: &Triangulation, from: u32, to: u32) -> u32 {
        let all = (0..3 * mesh.capacity() as u32).filter(|&e| mesh.is_alive(e / 3));
        all.into_iter().find(|&e| mesh.origin(e) == from && mesh.origin(next(e)) == to).unwrap()
    }

    #[test]
    fn changes_keep_neighbours_linked() {
        let mut mesh = square();
        let at = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        assert_eq!(flaw(&mesh), None);
        mesh.split_edge(edge(&mesh, 0, 2), at(24.0, 24.0));
        assert_eq!((flaw(&mesh), mesh.count()), (None, 4));
        mesh.split_edge(edge(&mesh, 0, 1), at(20.0, 0.0));
        assert_eq!((flaw(&mesh), mesh.count()), (None, 5));
        let added = mesh.split_face(edge(&mesh, 1, 2) / 3, at(40.0, 24.0));
        assert_eq!((flaw(&mesh), added.len(), mesh.count()), (None, 3, 7));
        let turned = edge(&mesh, 1, 4);
        mesh.flip(turned, mesh.twin(turned).unwrap());
        assert_eq!((flaw(&mesh), mesh.count()), (None, 7));
        // Vertex 4 is in the middle, vertex 6 beside the eastern side: a collapse of 6 to 1 reaches the outline.
        for (from, to) in [(6, 1), (4, 5)] {
            let star = mesh.star(from).unwrap();
            mesh.collapse(edge(&mesh, from, to), &star);
            assert_eq!(flaw(&mesh), None, "{from} to {to}");
        }
        assert_eq!(mesh.count(), 3);
        mesh.split_face(edge(&mesh, 2, 3) / 3, at(20.0, 40.0));
        assert_eq!((flaw(&mesh), mesh.count(), mesh.capacity()), (None, 5, 7));
        assert_eq!(mesh.surface().faces.len(), 5);
    }

    #[test]
    fn a_broken_mesh_is_found() {
        let mut mesh = square();
        let diagonal = edge(&mesh, 0, 2);
        mesh.twins[diagonal as usize] = NONE;
        assert_eq!(flaw(&mesh), Some("twin"));
        let mut mesh = square();
        mesh.leaving[1] = edge(&mesh, 0, 1);
        assert_eq!(flaw(&mesh), Some("leaving"));
        let mut mesh = square();
        mesh.positions[1].x = 47.0;
        assert_eq!(flaw(&mesh), Some("area"));
    }

    #[test]
    fn stars_are_complete_inside_and_absent_on_the_outline() {
        let mut mesh = square();
        mesh.split_face(0, DVec3::new(40.0, 20.0, 0.0));
        assert_eq!(mesh.star(4).map(|star| star.len()), Some(3));
        assert_eq!(mesh.star(0), None);
    }
}
