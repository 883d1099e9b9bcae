//! Progressive meshes (Hoppe 1996): a coarsest mesh and the vertex splits that lead from it to the full one, forwards and
//! backwards. In: a mesh with the collapses that took place on it, or half-edge collapses of a heightfield. Out: any mesh of
//! the sequence; vertices and faces are numbered in the order in which they appear, so that every mesh of it is a prefix.

use super::mesh::{FaceMesh, NONE};
use super::outline::Outline;
use super::split::{Refusal, VertexSplit};
use super::ClassicError;
use crate::Heightfield;

/// A mesh that can be refined and coarsened one vertex at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgressiveMesh {
    mesh: FaceMesh,
    splits: Vec<VertexSplit>,
    done: usize,
}

impl ProgressiveMesh {
    /// A progressive mesh from what is left of a mesh and the collapses that took place on it, first to last. It begins at
    /// its coarsest.
    pub(super) fn from_collapses(coarsest: &FaceMesh, collapses: &[VertexSplit]) -> ProgressiveMesh {
        let mut vertices = Numbers::new(coarsest.positions.len(), coarsest.living_vertices());
        let mut faces = Numbers::new(coarsest.faces.len(), coarsest.living_faces());
        let surface = coarsest.surface();
        let mesh = FaceMesh::new(surface.positions, surface.faces).expect("collapses leave a manifold");
        let renumber = |split: &VertexSplit| VertexSplit {
            vs: vertices.of(split.vs),
            vu: vertices.add(split.vu),
            f: split.f.map(|face| faces.of(face)),
            fl: faces.add(split.fl),
            fr: faces.add(split.fr),
            ..*split
        };
        ProgressiveMesh { mesh, splits: collapses.iter().rev().map(renumber).collect(), done: 0 }
    }

    /// The progressive mesh of half-edge collapses on the full grid of a heightfield: `order` lists samples first to last,
    /// and each collapses into its neighbour `parent[sample]`. Vertices never move.
    ///
    /// # Errors
    /// If the field lacks data, or a collapse is none: the step, both samples and why.
    pub fn from_half_edge_collapses(field: &Heightfield, order: &[u32], parent: &[u32]) -> Result<ProgressiveMesh, ClassicError> {
        super::refuse_gaps(field)?;
        let samples = field.heights().len();
        if parent.len() != samples {
            return Err(ClassicError::Parents { found: parent.len(), expected: samples });
        }
        let outline = Outline::of(field);
        let mut mesh = FaceMesh::from_heightfield(field);
        let mut collapses = Vec::with_capacity(order.len());
        for (step, &sample) in order.iter().enumerate() {
            let into = parent.get(sample as usize).copied().unwrap_or(NONE);
            let refused = |reason| ClassicError::Collapse { step, sample, into, reason };
            let split = half_edge_collapse(&mesh, &outline, sample, into).map_err(refused)?;
            split.ecol(&mut mesh);
            collapses.push(split);
        }
        Ok(ProgressiveMesh::from_collapses(&mesh, &collapses))
    }

    /// The mesh as it stands: without empty slots, its vertices and faces in the order in which they appeared.
    pub fn mesh(&self) -> &FaceMesh {
        &self.mesh
    }

    /// All splits, from the coarsest mesh on.
    pub fn splits(&self) -> &[VertexSplit] {
        &self.splits
    }

    /// Faces of the mesh as it stands.
    pub fn faces(&self) -> usize {
        self.mesh.faces.len()
    }

    /// Performs the next vertex split; false if the mesh is full.
    #[allow(clippy::should_implement_trait, reason = "the name that Hoppe gave it; an iterator cannot go back")]
    pub fn next(&mut self) -> bool {
        let Some(split) = self.splits.get(self.done) else { return false };
        self.mesh.positions.push(split.vu_position);
        self.mesh.face_of.push(NONE);
        for _ in 0..split.new_faces() {
            self.mesh.faces.push([NONE; 3]);
            self.mesh.neighbours.push([NONE; 3]);
        }
        split.vsplit(&mut self.mesh);
        self.done += 1;
        true
    }

    /// Undoes the last vertex split; false if the mesh is at its coarsest.
    pub fn prev(&mut self) -> bool {
        let Some(before) = self.done.checked_sub(1) else { return false };
        let split = self.splits[before];
        split.ecol(&mut self.mesh);
        self.mesh.positions.pop();
        self.mesh.face_of.pop();
        let faces = self.mesh.faces.len() - split.new_faces();
        self.mesh.faces.truncate(faces);
        self.mesh.neighbours.truncate(faces);
        self.done = before;
        true
    }

    /// Goes to the finest mesh of at most `faces` faces, or to the coarsest if that has more. Returns its faces.
    pub fn set_faces(&mut self, faces: usize) -> usize {
        while self.faces() > faces && self.prev() {}
        while self.splits.get(self.done).is_some_and(|split| self.faces() + split.new_faces() <= faces) {
            self.next();
        }
        self.faces()
    }
}

/// The collapse of one sample of a heightfield into another.
fn half_edge_collapse(mesh: &FaceMesh, outline: &Outline, sample: u32, into: u32) -> Result<VertexSplit, Refusal> {
    let living = |v: u32| mesh.face_of.get(v as usize).is_some_and(|&face| face != NONE);
    if !living(sample) || !living(into) {
        return Err(Refusal::NoEdge);
    }
    if !outline.may_fall(sample, into) {
        return Err(Refusal::Outline);
    }
    let split = VertexSplit::of_edge(mesh, into, sample, mesh.positions[into as usize])?;
    if split.inverts(mesh, 0.0) {
        return Err(Refusal::Inversion);
    }
    Ok(split)
}

/// New numbers by old.
struct Numbers {
    new: Vec<u32>,
    count: u32,
}

impl Numbers {
    fn new(slots: usize, living: impl Iterator<Item = u32>) -> Numbers {
        let mut numbers = Numbers { new: vec![NONE; slots], count: 0 };
        living.for_each(|old| {
            numbers.add(old);
        });
        numbers
    }

    fn of(&self, old: u32) -> u32 {
        self.new.get(old as usize).copied().unwrap_or(NONE)
    }

    fn add(&mut self, old: u32) -> u32 {
        if old != NONE {
            self.new[old as usize] = self.count;
            self.count += 1;
        }
        self.of(old)
    }
}
