//! Edge collapse and vertex split, each the other's inverse (Hoppe, "Progressive meshes", 1996; the neighbour faces f0 to f3
//! as in Hoppe, "View-dependent refinement of progressive meshes", 1997). In: a mesh and an edge. Out: a record that
//! performs and undoes the collapse in time proportional to the rings of the edge's ends.
//!
//! ```text
//!         vu                    f1 \ | / f3
//!       / | \                       \|/
//!  f1  /  |  \  f3      ecol    vl---vs---vr
//!    vl fl|fr vr       ----->       /|\
//!  f0  \  |  /  f2     <-----   f0 / | \ f2
//!       \ | /          vsplit
//!         vt
//! ```
//!
//! Any of f0 to f3 may be missing at a border, and fl or fr if the edge itself lies on one. The vertices vl and vr are not
//! stored: they are the neighbours of vs along the sides that f0 to f3 name.

use super::mesh::{FaceMesh, NONE};
use glam::DVec3;

/// A vertex split: vs gives way to vt and vu, and the faces fl = (vt, vu, vl) and fr = (vu, vt, vr) open between f0 and f1 and
/// between f2 and f3. vt takes the slot of vs in the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexSplit {
    /// The vertex that splits; afterwards the slot of vt.
    pub vs: u32,
    /// The vertex that appears.
    pub vu: u32,
    /// The face that appears to the left, looking from vt to vu, or [`NONE`].
    pub fl: u32,
    /// The face that appears to the right, or [`NONE`].
    pub fr: u32,
    /// Neighbour faces f0 to f3, or [`NONE`]: of fl at vt and at vu, of fr at vt and at vu.
    pub f: [u32; 4],
    /// Position of vs before the split.
    pub vs_position: DVec3,
    /// Position of vt after it.
    pub vt_position: DVec3,
    /// Position of vu after it.
    pub vu_position: DVec3,
}

/// Why an edge cannot collapse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such edge.
    #[error("the two vertices do not share an edge")]
    NoEdge,
    /// The link condition (Dey, Edelsbrunner, Guha and Nekhayev 1999): the ends have a common neighbour besides vl and vr, so that
    /// two faces would come to lie on one another.
    #[error("the two vertices have a common neighbour apart from the two faces of their edge")]
    AlreadyAdjacent,
    /// Both ends lie on a border and the edge between them does not: the surface would be pinched.
    #[error("the edge crosses the surface from border to border")]
    AcrossBorders,
    /// A face of the edge has no other neighbour: its third vertex would be left without a face.
    #[error("a face of the edge hangs on nothing else")]
    LastFace,
    /// A corner of the domain would move, or a vertex leave its side.
    #[error("a corner of the domain would move, or a vertex would leave the side that it lies on")]
    Outline,
    /// A triangle would turn over or lose its area, seen from above.
    #[error("a triangle would turn over")]
    Inversion,
}

impl VertexSplit {
    /// The split that the collapse of vu and vt into one vertex at `position` would leave behind. Changes nothing.
    ///
    /// # Errors
    /// Why the edge cannot collapse, as far as connectivity tells.
    pub fn of_edge(mesh: &FaceMesh, vt: u32, vu: u32, position: DVec3) -> Result<VertexSplit, Refusal> {
        let [fl, fr] = [(vt, vu), (vu, vt)].map(|(a, b)| mesh.left_of(a, b).unwrap_or(NONE));
        if fl == NONE && fr == NONE {
            return Err(Refusal::NoEdge);
        }
        // Beyond the face `face`, across the side opposite `vertex`.
        let beyond = |face: u32, vertex: u32| mesh.corner_in(face, vertex).map_or(NONE, |k| mesh.neighbours[face as usize][k]);
        let f = [beyond(fl, vu), beyond(fl, vt), beyond(fr, vu), beyond(fr, vt)];
        if (fl != NONE && f[0] == NONE && f[1] == NONE) || (fr != NONE && f[2] == NONE && f[3] == NONE) {
            return Err(Refusal::LastFace);
        }
        check_link(mesh, vt, vu, [fl, fr])?;
        let [vt_position, vu_position] = [vt, vu].map(|v| mesh.positions[v as usize]);
        Ok(VertexSplit { vs: vt, vu, fl, fr, f, vs_position: position, vt_position, vu_position })
    }

    /// The slot of vt, which is that of vs.
    pub fn vt(&self) -> u32 {
        self.vs
    }

    /// Faces that appear: 1 or 2.
    pub fn new_faces(&self) -> usize {
        usize::from(self.fl != NONE) + usize::from(self.fr != NONE)
    }

    /// vl and vr in the unsplit mesh, or [`NONE`]: vl comes after vs in f0 and before it in f1, vr before it in f2 and after it in f3.
    pub fn side_vertices(&self, mesh: &FaceMesh) -> [u32; 2] {
        let at = |face: u32, step: usize| mesh.corner_in(face, self.vs).map(|k| mesh.faces[face as usize][(k + step) % 3]);
        let [f0, f1, f2, f3] = self.f;
        [at(f0, 1).or(at(f1, 2)).unwrap_or(NONE), at(f2, 2).or(at(f3, 1)).unwrap_or(NONE)]
    }

    /// Whether collapsing the edge would turn a triangle over, or leave it an area of at most `least`, seen from above.
    pub fn inverts(&self, mesh: &FaceMesh, least: f64) -> bool {
        let spoiled = |vertex: u32| {
            mesh.star(vertex).filter(|&(face, _)| face != self.fl && face != self.fr).any(|(face, corner)| {
                let corners = mesh.faces[face as usize];
                let [a, b] = [1, 2].map(|k| (mesh.positions[corners[(corner + k) % 3] as usize] - self.vs_position).truncate());
                a.perp_dot(b) <= 2.0 * least
            })
        };
        spoiled(self.vt()) || spoiled(self.vu)
    }

    /// Edge collapse: vt and vu become vs, fl and fr disappear.
    pub fn ecol(&self, mesh: &mut FaceMesh) {
        let sides = [self.fl, self.fr].map(|face| self.third_corner(mesh, face));
        self.move_fan(mesh, self.vu, self.vs);
        self.link_neighbours(mesh, self.f[1], self.f[0], self.f[3], self.f[2]);
        let old = [mesh.face_of[self.vs as usize], mesh.face_of[self.vu as usize], self.f[0], self.f[1], self.f[2], self.f[3]];
        let lowest = old.into_iter().filter(|&face| face != NONE && face != self.fl && face != self.fr).min();
        mesh.face_of[self.vs as usize] = lowest.unwrap_or(NONE);
        mesh.face_of[self.vu as usize] = NONE;
        for (vertex, face, pair) in [(sides[0], self.fl, [0, 1]), (sides[1], self.fr, [2, 3])] {
            if vertex != NONE && mesh.face_of[vertex as usize] == face {
                mesh.face_of[vertex as usize] = pair.map(|k| self.f[k]).into_iter().min().unwrap_or(NONE);
            }
        }
        for face in [self.fl, self.fr].into_iter().filter(|&face| face != NONE) {
            mesh.faces[face as usize] = [NONE; 3];
            mesh.neighbours[face as usize] = [NONE; 3];
        }
        mesh.positions[self.vs as usize] = self.vs_position;
    }

    /// Vertex split: vs becomes vt and vu, fl and fr appear in their slots, which are there and empty.
    pub fn vsplit(&self, mesh: &mut FaceMesh) {
        let [vl, vr] = self.side_vertices(mesh);
        self.link_neighbours(mesh, self.fl, self.fl, self.fr, self.fr);
        self.move_fan(mesh, self.vs, self.vu);
        let [vt, vu] = [self.vt(), self.vu];
        let [f0, f1, f2, f3] = self.f;
        if self.fl != NONE {
            mesh.faces[self.fl as usize] = [vt, vu, vl];
            mesh.neighbours[self.fl as usize] = [f1, f0, self.fr];
        }
        if self.fr != NONE {
            mesh.faces[self.fr as usize] = [vu, vt, vr];
            mesh.neighbours[self.fr as usize] = [f2, f3, self.fl];
        }
        mesh.positions[vt as usize] = self.vt_position;
        mesh.positions[vu as usize] = self.vu_position;
        // The lowest face of either, so that a collapse finds back to the bits before the split.
        for vertex in [vt, vu] {
            mesh.face_of[vertex as usize] = if self.fl == NONE { self.fr } else { self.fl };
            let lowest = mesh.star(vertex).map(|(face, _)| face).min();
            mesh.face_of[vertex as usize] = lowest.unwrap_or(NONE);
        }
    }

    /// The corner of a face that is neither vt nor vu.
    fn third_corner(&self, mesh: &FaceMesh, face: u32) -> u32 {
        let corners = if face == NONE { [NONE; 3] } else { mesh.faces[face as usize] };
        corners.into_iter().find(|&v| v != self.vs && v != self.vu).unwrap_or(NONE)
    }

    /// The faces of vu that outlive the collapse get the corner `to` for `from`: from f1 clockwise to f3, or both ways to the
    /// border if vu lies on one.
    fn move_fan(&self, mesh: &mut FaceMesh, from: u32, to: u32) {
        let [_, f1, _, f3] = self.f;
        let mut face = f1;
        while let Some(corner) = mesh.corner_in(face, from) {
            mesh.faces[face as usize][corner] = to;
            if face == f3 {
                return;
            }
            face = mesh.clockwise(face, corner);
        }
        face = f3;
        while let Some(corner) = mesh.corner_in(face, from) {
            mesh.faces[face as usize][corner] = to;
            face = mesh.counter_clockwise(face, corner);
        }
    }

    /// Sets what f0 to f3 have for neighbours across their sides at vl and vr. Their corners are all at vs.
    fn link_neighbours(&self, mesh: &mut FaceMesh, of_f0: u32, of_f1: u32, of_f2: u32, of_f3: u32) {
        // The side from vs to the corner after it lies opposite the second corner after it, and the other way round.
        for (face, step, neighbour) in [(0, 2, of_f0), (1, 1, of_f1), (2, 1, of_f2), (3, 2, of_f3)] {
            let face = self.f[face];
            if let Some(corner) = mesh.corner_in(face, self.vs) {
                mesh.neighbours[face as usize][(corner + step) % 3] = neighbour;
            }
        }
    }
}

/// Refuses edges whose collapse would not leave a manifold.
fn check_link(mesh: &FaceMesh, vt: u32, vu: u32, faces: [u32; 2]) -> Result<(), Refusal> {
    let (mut at_vt, mut at_vu) = (Vec::with_capacity(8), Vec::with_capacity(8));
    let closed = [mesh.ring(vt, &mut at_vt), mesh.ring(vu, &mut at_vu)];
    let sides = faces.iter().filter(|&&face| face != NONE).count();
    if closed == [false; 2] && sides == 2 {
        return Err(Refusal::AcrossBorders);
    }
    let common = at_vt.iter().filter(|v| at_vu.contains(v)).count();
    let tetrahedron = closed == [true; 2] && at_vt.len() == 3 && at_vu.len() == 3;
    if common != sides || tetrahedron {
        return Err(Refusal::AlreadyAdjacent);
    }
    Ok(())
}
