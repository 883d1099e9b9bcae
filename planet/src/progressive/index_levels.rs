//! Triangle lists of a patch, one per halving of the vertex count.
//!
//! Level k is the mesh in which only the first `vertices` places of the wake order are awake. For any awake set within that
//! prefix, a triangle that is degenerate in level k is degenerate for good, because the first awake ancestor of a vertex is
//! that of its first ancestor in the prefix. All levels together hold twice the triangles of the finest.

use super::patch_mesh::PatchMesh;
use crate::simplify::mesh::grid_triangles;

/// Smallest prefix that gets a triangle list of its own.
const SMALLEST: usize = 64;

/// One triangle list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexLevel {
    /// Number of vertices, from the start of the wake order, that it uses.
    pub vertices: u32,
    /// First triangle in [`IndexLevels::triangles`].
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
}

/// All triangle lists of a patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndexLevels {
    /// The levels, finest first.
    pub levels: Vec<IndexLevel>,
    /// Triangles of all levels, as places in the wake order, counter-clockwise from outside, row by row within a level.
    pub triangles: Vec<[u16; 3]>,
}

impl IndexLevels {
    /// Lists of a patch.
    pub fn new(mesh: &PatchMesh) -> IndexLevels {
        let mut place = vec![0u16; mesh.vertices.len()];
        for (k, vertex) in mesh.vertices.iter().enumerate() {
            place[usize::from(vertex.grid)] = k as u16;
        }
        let finest = grid_triangles(mesh.cells);
        let mut lists = IndexLevels { levels: Vec::new(), triangles: Vec::with_capacity(2 * finest.len() + 1024) };
        lists.triangles.extend(finest.iter().map(|t| t.map(|v| place[v as usize])));
        let mut vertices = mesh.vertices.len();
        lists.levels.push(IndexLevel { vertices: vertices as u32, first: 0, count: finest.len() as u32 });
        while vertices / 2 >= SMALLEST {
            vertices /= 2;
            lists.push_level(mesh, vertices);
        }
        lists
    }

    fn push_level(&mut self, mesh: &PatchMesh, vertices: usize) {
        let Some(&finer) = self.levels.last() else { return };
        // First ancestor inside the prefix; parents come before children, so one pass settles all.
        let mut inside: Vec<u16> = (0..finer.vertices as u16).collect();
        for k in vertices..finer.vertices as usize {
            inside[k] = inside[usize::from(mesh.vertices[k].parent)];
        }
        let first = self.triangles.len();
        for t in finer.first as usize..(finer.first + finer.count) as usize {
            let triangle = self.triangles[t].map(|v| inside[usize::from(v)]);
            let [a, b, c] = triangle;
            if a != b && b != c && c != a {
                self.triangles.push(triangle);
            }
        }
        let count = (self.triangles.len() - first) as u32;
        self.levels.push(IndexLevel { vertices: vertices as u32, first: first as u32, count });
    }
}

/// The coarsest of a patch's levels (finest first, at least one) that holds the first `vertices` places of the wake order.
pub fn covering(levels: &[IndexLevel], vertices: usize) -> IndexLevel {
    let fits = |level: &&IndexLevel| level.vertices as usize >= vertices;
    levels.iter().rev().find(fits).copied().unwrap_or(levels[0])
}
