//! Triangle lists of a patch: index levels, and within each of them tiles.
//!
//! A level is the mesh in which only the first `vertices` of the wake order are awake. For any awake set within that
//! prefix, a triangle that is degenerate in the level is degenerate for good, because the first awake ancestor of a vertex is
//! that of its first ancestor in the prefix. A triangle of the full grid belongs to the tile that its cell lies in, however far its
//! corners move from level to level; so every tile of a patch can be drawn from a level of its own.

use super::mesh_prefix::MeshPrefix;
use std::ops::Range;
use terrane_heightfield::decimate::mesh::grid_triangles;

/// Tiles along a side of a patch.
pub const TILES_ALONG: usize = 4;

/// Tiles of a patch, row by row.
pub const TILES: usize = TILES_ALONG * TILES_ALONG;

/// Smallest prefix that gets a triangle list of its own.
const SMALLEST: usize = 16;

/// The largest levels halve the vertex count, the others take off a fifth: large lists cost much memory and are rarely wanted.
const HALVINGS: usize = 2;

/// The triangles of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexLevel {
    /// Number of vertices, from the start of the wake order, that it uses.
    pub vertices: u32,
    /// First triangle of every tile in [`IndexLevels::triangles`], and the end of the last.
    first: [u32; TILES + 1],
}

impl IndexLevel {
    /// Its first triangle; those of coarser levels follow.
    pub fn start(&self) -> u32 {
        self.first[0]
    }

    /// Its triangles in one tile.
    pub fn tile(&self, tile: usize) -> Range<u32> {
        self.first[tile]..self.first[tile + 1]
    }
}

/// All triangle lists of a patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndexLevels {
    /// The levels, finest first.
    pub levels: Vec<IndexLevel>,
    /// Triangles of all levels, as vertex indices, counter-clockwise from outside, tile by tile within a level and row by
    /// row within a tile. All levels together hold 2.75 times the triangles of the finest.
    pub triangles: Vec<[u16; 3]>,
}

impl IndexLevels {
    /// Lists of a patch as far as its vertices are there: the finest level has all of them.
    pub fn new(prefix: &MeshPrefix) -> IndexLevels {
        let (mesh, all) = (&prefix.mesh, prefix.falls.len());
        let mut tiles = full_grid(prefix);
        // First ancestor inside the level's prefix.
        let mut inside: Vec<u16> = (0..mesh.vertices.len() as u16).collect();
        let mut lists = IndexLevels { levels: Vec::new(), triangles: Vec::with_capacity(6 * mesh.vertices.len()) };
        let there = mesh.vertices.len();
        for vertices in std::iter::once(there).chain(level_sizes(all).filter(|&size| size < there)) {
            // Parents come before children, so one pass settles all.
            for k in vertices..inside.len() {
                inside[k] = inside[usize::from(mesh.vertices[k].parent)];
            }
            tiles.iter_mut().for_each(|tile| collapse(tile, &inside));
            inside.truncate(vertices);
            lists.push(vertices, &tiles);
        }
        lists
    }

    fn push(&mut self, vertices: usize, tiles: &[Vec<[u16; 3]>; TILES]) {
        let mut first = [self.triangles.len() as u32; TILES + 1];
        for (tile, end) in tiles.iter().zip(&mut first[1..]) {
            self.triangles.extend_from_slice(tile);
            *end = self.triangles.len() as u32;
        }
        self.levels.push(IndexLevel { vertices: vertices as u32, first });
    }
}

/// Tile of the cell in a column and a row of a grid of `cells` cells a side.
pub fn tile_of_cell(column: usize, row: usize, cells: usize) -> usize {
    row * TILES_ALONG / cells * TILES_ALONG + column * TILES_ALONG / cells
}

/// Triangles of the full grid by tile, with what their corners fall to.
fn full_grid(prefix: &MeshPrefix) -> [Vec<[u16; 3]>; TILES] {
    let cells = prefix.mesh.cells as usize;
    let mut tiles: [Vec<[u16; 3]>; TILES] = Default::default();
    for (cell, pair) in grid_triangles(prefix.mesh.cells).chunks(2).enumerate() {
        tiles[tile_of_cell(cell % cells, cell / cells, cells)].extend(pair.iter().map(|t| t.map(|v| prefix.falls[v as usize])));
    }
    tiles
}

/// Replaces corners by what they fall to, and drops triangles that have become degenerate.
fn collapse(triangles: &mut Vec<[u16; 3]>, inside: &[u16]) {
    triangles.retain_mut(|triangle| {
        *triangle = triangle.map(|v| inside[usize::from(v)]);
        let [a, b, c] = *triangle;
        a != b && b != c && c != a
    });
}

/// Vertex counts of the levels, finest first.
fn level_sizes(vertices: usize) -> impl Iterator<Item = usize> {
    let smaller = |&(number, size): &(usize, usize)| Some((number + 1, if number < HALVINGS { size / 2 } else { size * 4 / 5 }));
    let sizes = std::iter::successors(Some((0, vertices)), smaller).map(|(_, size)| size);
    sizes.take_while(move |&size| size >= SMALLEST || size == vertices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_become_finer_steps_and_end() {
        let sizes: Vec<usize> = level_sizes(129 * 129).collect();
        assert_eq!(sizes[..5], [16_641, 8320, 4160, 3328, 2662]);
        assert!(sizes.len() == 27 && sizes.iter().all(|&s| s >= SMALLEST), "{sizes:?}");
        assert_eq!(level_sizes(9).collect::<Vec<_>>(), [9]);
    }

    #[test]
    fn tiles_divide_the_grid() {
        for cells in [8usize, 16, 128] {
            let mut cells_of = [0; TILES];
            (0..cells * cells).for_each(|k| cells_of[tile_of_cell(k % cells, k / cells, cells)] += 1);
            assert_eq!(cells_of, [cells * cells / TILES; TILES]);
        }
        assert_eq!(tile_of_cell(127, 32, 128), 7);
    }
}
