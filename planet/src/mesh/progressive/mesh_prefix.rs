//! The first vertices of a mesh, and what draws the others while they sleep: all of it that a view needs which wakes none of the others.

use super::patch_mesh::{PatchMesh, Vertex};
use crate::mesh::wake::Wake;

/// The first vertices of a mesh, or all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPrefix {
    /// The mesh, with these vertices alone.
    pub mesh: PatchMesh,
    /// For every grid position the vertex index of the vertex there or, if that is none of these, of the first of its ancestors that is.
    pub falls: Vec<u16>,
    /// The largest wake of the vertices that are not here; [`Wake::ASLEEP`] if all are.
    pub beyond: Wake,
}

impl MeshPrefix {
    /// The first `count` vertices of a whole mesh, at least one.
    pub fn of(mesh: &PatchMesh, count: usize) -> MeshPrefix {
        let vertices = mesh.vertices.iter().take(count).copied().collect();
        let beyond = mesh.vertices.get(count).map_or(Wake::ASLEEP, Vertex::largest_wake);
        let falls = falls(&mesh.vertices, count);
        MeshPrefix { mesh: PatchMesh { vertices, ..*mesh }, falls, beyond }
    }

    /// Whether no vertex is missing.
    pub fn is_whole(&self) -> bool {
        self.mesh.vertices.len() == self.falls.len()
    }
}

impl From<PatchMesh> for MeshPrefix {
    fn from(mesh: PatchMesh) -> MeshPrefix {
        let falls = falls(&mesh.vertices, mesh.vertices.len());
        MeshPrefix { mesh, falls, beyond: Wake::ASLEEP }
    }
}

/// For every grid position of a mesh the vertex index of the first of its ancestors that is among the first `prefix` vertices. What never
/// collapses and is not among these falls to the first vertex: no view does without it.
pub fn falls(vertices: &[Vertex], prefix: usize) -> Vec<u16> {
    let mut inside: Vec<u16> = (0..vertices.len() as u16).collect();
    let mut falls = vec![0; vertices.len()];
    for (k, vertex) in vertices.iter().enumerate() {
        if k >= prefix {
            inside[k] = if usize::from(vertex.parent) == k { 0 } else { inside[usize::from(vertex.parent)] };
        }
        falls[usize::from(vertex.grid)] = inside[k];
    }
    falls
}
