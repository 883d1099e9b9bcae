//! What a view has to look at of a patch: a prefix of its vertices to select and resolve, and the triangles that emission begins
//! with. Runs on the CPU, as the cut does, for every patch that is in sight.
//!
//! In: a view, and of the patch how far away its vertices can be awake. Out: [`Work`]. Whatever a view leaves out, it leaves out
//! because it is asleep for certain, so the drawn triangles are those that all vertices and all triangles would give.

use super::cut::distance_to_box;
use super::layout::PatchVertex;
use super::view::View;
use crate::globe::lattice::LatticeBox;
use crate::mesh::progressive::index_levels::{tile_of_cell, IndexLevel, IndexLevels, TILES};
use crate::mesh::progressive::MeshPrefix;
use crate::mesh::wake::Wake;
use glam::IVec3;
use std::ops::Range;

/// What a view looks at of one patch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Vertices from the start of the wake order: all that can be awake, and all corners of the triangles.
    pub vertices: u32,
    /// Triangles in the patch's lists, as runs that do not touch.
    pub triangles: Vec<Range<u32>>,
}

impl Work {
    /// Number of triangles.
    pub fn triangle_count(&self) -> u32 {
        self.triangles.iter().map(|run| run.end - run.start).sum()
    }
}

/// From how far away the vertices of a patch can be awake: what decides how much of it a view looks at.
#[derive(Clone, Debug)]
pub struct Reach {
    levels: Vec<IndexLevel>,
    /// For every level, what each of its tiles leaves out of the vertices that are there.
    beyond: Vec<[Beyond; TILES]>,
    /// The vertices that are not.
    missing: Beyond,
}

/// The vertices that one tile leaves out at some level: of all that its grid vertices can be drawn as, those behind the prefix.
#[derive(Clone, Copy, Debug)]
struct Beyond {
    bounds: LatticeBox,
    /// The largest wake among them.
    wake: Wake,
}

impl Beyond {
    const NOTHING: Beyond = Beyond { bounds: LatticeBox::EMPTY, wake: Wake::ASLEEP };

    fn include(&mut self, vertex: &PatchVertex) {
        self.bounds.include(IVec3::from_array(vertex.position));
        self.wake = self.wake.max(vertex.largest_wake());
    }

    fn sleeps(&self, view: &View) -> bool {
        sleeps(view, &self.bounds, self.wake)
    }
}

/// Whether all vertices in a box whose wakes are at most `wake` sleep in a view. The selection distance is taken a little nearer than true,
/// for the rounding of f32 selection.
pub fn sleeps(view: &View, bounds: &LatticeBox, wake: Wake) -> bool {
    let nearest = || distance_to_box(view, bounds) * (1.0 - 1e-5);
    wake == Wake::ASLEEP || nearest() > view.reach * wake.distance()
}

impl Reach {
    /// The reach of a patch with the vertices of a prefix and their triangle lists.
    pub fn new(vertices: &[PatchVertex], prefix: &MeshPrefix, lists: &IndexLevels) -> Reach {
        let tiles = tiles_of(vertices, prefix);
        let missing = Beyond { bounds: prefix.mesh.facts.bounds, wake: prefix.beyond };
        let mut end = vertices.len();
        let mut beyond = [Beyond::NOTHING; TILES];
        let leave_out = |level: &IndexLevel| {
            for k in level.vertices as usize..end {
                let used_by = |tile: &usize| tiles[k] >> tile & 1 == 1;
                (0..TILES).filter(used_by).for_each(|tile| beyond[tile].include(&vertices[k]));
            }
            end = level.vertices as usize;
            beyond
        };
        Reach { levels: lists.levels.clone(), beyond: lists.levels.iter().map(leave_out).collect(), missing }
    }

    /// Whether all vertices are there that any view wakes.
    pub fn is_whole(&self) -> bool {
        self.missing.wake == Wake::ASLEEP
    }

    /// Whether all vertices sleep in a view that are not there: what follows is about the others, and of use only then.
    pub fn suffices(&self, view: &View) -> bool {
        self.missing.sleeps(view)
    }

    /// The coarsest level, by number, of which a view needs nothing finer anywhere.
    pub fn finest(&self, view: &View) -> usize {
        (0..TILES).map(|tile| self.level_of(tile, view)).min().unwrap_or(0)
    }

    /// The coarsest level, by number, whose left-out vertices of a tile all sleep.
    fn level_of(&self, tile: usize, view: &View) -> usize {
        // A coarser level leaves out whatever a finer one does. The finest leaves out nothing.
        self.beyond.partition_point(|level| level[tile].sleeps(view)).saturating_sub(1)
    }

    /// What a view looks at: every tile from the coarsest level whose left-out vertices all sleep.
    pub fn work(&self, view: &View) -> Work {
        let mut work = Work::default();
        for tile in 0..TILES {
            let level = &self.levels[self.level_of(tile, view)];
            work.vertices = work.vertices.max(level.vertices);
            let run = level.tile(tile);
            match work.triangles.last_mut() {
                Some(last) if last.end == run.start => last.end = run.end,
                _ if run.is_empty() => {}
                _ => work.triangles.push(run),
            }
        }
        work
    }
}

/// For every vertex, the tiles (as bits) with a grid vertex that can be drawn as it: those of all grid vertices that fall to it.
fn tiles_of(vertices: &[PatchVertex], prefix: &MeshPrefix) -> Vec<u32> {
    let cells = prefix.mesh.cells as usize;
    let around = |at: usize| [at.saturating_sub(1), at.min(cells - 1)];
    let own = |grid: usize| {
        let (column, row) = (grid % (cells + 1), grid / (cells + 1));
        let tiles = around(column).into_iter().flat_map(|c| around(row).map(|r| tile_of_cell(c, r, cells)));
        tiles.fold(0u32, |bits, tile| bits | 1 << tile)
    };
    let mut tiles = vec![0; vertices.len()];
    prefix.falls.iter().enumerate().for_each(|(grid, &vertex)| tiles[usize::from(vertex)] |= own(grid));
    // Children come after their parents, so one pass from the end settles all.
    for k in (0..vertices.len()).rev() {
        let bits = tiles[k];
        tiles[vertices[k].parent() as usize] |= bits;
    }
    tiles
}
