//! Checks of the invariants on drawn meshes, in the places where they are drawn: watertight by bits, nothing flipped or degenerate,
//! closure kept; and the screen error, measured with rays against the finest resident surface.

pub mod error_readings;
pub mod finest;
pub mod random_views;
pub mod screen_error;
pub mod surface_check;

pub use error_readings::{ErrorReadings, Probe, Reading};
pub use finest::{FinestSurface, GridCache};
pub use random_views::RandomViews;
pub use screen_error::{measure, Drawn, Effort, ScreenError};
pub use surface_check::{SurfaceCheck, SurfaceReport};

use crate::lattice::Lattice;
use crate::layout::PatchVertex;
use crate::progressive::{covering, replay, IndexLevel, IndexLevels, PatchMesh};
use crate::reference::resolve::bit;
use crate::wake::Wake;

/// A patch with everything the checks and the run time need.
pub struct LoadedPatch {
    /// The progressive mesh.
    pub mesh: PatchMesh,
    /// Its vertices as the GPU sees them.
    pub vertices: Vec<PatchVertex>,
    /// Its triangle lists.
    pub lists: IndexLevels,
    /// What decides which list a view needs.
    pub reach: Reach,
}

/// How far the vertices of a patch can be awake, and the triangle list for every prefix of them.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Larger wake of each vertex, falling.
    wakes: Vec<Wake>,
    levels: Vec<IndexLevel>,
}

impl Reach {
    /// The coarsest triangle list that holds every vertex which can be awake for a viewer at least `distance` lattice units
    /// away (selection distance) in a view of some reach.
    pub fn level_for(&self, distance: f64, reach: f64) -> IndexLevel {
        // A little nearer than true, for the rounding of f32 selection.
        let least = distance * (1.0 - 1e-5) / reach;
        let awake = self.wakes.partition_point(|w| w.distance() >= least);
        covering(&self.levels, awake)
    }
}

impl LoadedPatch {
    /// Prepares a patch for drawing.
    pub fn new(mesh: PatchMesh, lattice: &Lattice) -> LoadedPatch {
        let vertices = PatchVertex::of_patch(&mesh, lattice);
        let lists = IndexLevels::new(&mesh);
        let wakes = mesh.vertices.iter().map(|v| v.wake()).collect();
        let reach = Reach { wakes, levels: lists.levels.clone() };
        LoadedPatch { mesh, vertices, lists, reach }
    }

    /// Triangles of one of its lists.
    pub fn triangles(&self, level: IndexLevel) -> &[[u16; 3]] {
        &self.lists.triangles[level.first as usize..(level.first + level.count) as usize]
    }
}

/// Rings of every collapse of a patch, flat, for closure checks.
pub struct Rings {
    start: Vec<u32>,
    members: Vec<u16>,
}

impl Rings {
    /// Replays a patch; `None` if its hierarchy does not replay.
    pub fn new(mesh: &PatchMesh) -> Option<Rings> {
        let lists = replay::rings(mesh)?;
        let mut rings = Rings { start: vec![0], members: Vec::with_capacity(6 * lists.len()) };
        for list in lists {
            rings.members.extend(list);
            rings.start.push(rings.members.len() as u32);
        }
        Some(rings)
    }

    /// Number of pairs of an awake vertex and a member of its ring that is not in its own place: 0 when the awake set is closed.
    /// `morph` holds the weights of a prefix, 1 for sleeping vertices; the others sleep.
    pub fn violations(&self, awake: &[u32], morph: &[f32]) -> usize {
        let moved_in_ring = |v: usize| {
            let members = &self.members[self.start[v] as usize..self.start[v + 1] as usize];
            members.iter().filter(|&&r| morph.get(usize::from(r)) != Some(&0.0)).count()
        };
        let count = morph.len().min(self.start.len() - 1);
        (0..count).filter(|&v| bit(awake, v as u32)).map(moved_in_ring).sum()
    }
}
