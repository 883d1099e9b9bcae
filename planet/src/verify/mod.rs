//! Checks of the invariants on drawn meshes, at drawn positions: watertight by bits, nothing flipped or degenerate,
//! closure kept; and the screen error, measured with rays against the finest resident surface.

pub mod error_readings;
pub mod finest;
pub mod random_views;
pub mod screen_error;
pub mod surface_check;

pub use error_readings::{ErrorReadings, Probe, Reading};
pub use finest::{FinestSurface, GridCache};
pub use random_views::{ground_views, RandomViews};
pub use screen_error::{is_in_view, measure, Drawn, Effort, ScreenError};
pub use surface_check::{SurfaceCheck, SurfaceReport};

use crate::draw::layout::DrawnVertex;
use crate::mesh::progressive::{replay, PatchMesh};
use crate::reference::resolve::bit;

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

    /// Number of pairs of an awake vertex and a member of its ring that is not in its own position: 0 when the awake set is
    /// closed. `awake` and `drawn_positions` cover a prefix; the others sleep.
    pub fn violations(&self, awake: &[u32], drawn_positions: &[DrawnVertex]) -> usize {
        let in_own_position = |r: u16| drawn_positions.get(usize::from(r)).is_some_and(|drawn| drawn.weight == 0.0);
        let moved_in_ring = |v: usize| {
            let members = &self.members[self.start[v] as usize..self.start[v + 1] as usize];
            members.iter().filter(|&&r| !in_own_position(r)).count()
        };
        let count = drawn_positions.len().min(self.start.len() - 1);
        (0..count).filter(|&v| bit(awake, v as u32)).map(moved_in_ring).sum()
    }
}
