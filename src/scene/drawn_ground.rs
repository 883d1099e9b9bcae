//! The ground that a scene draws, asked for on the CPU: what cameras stay above.

use super::options::Scope;
use glam::DVec3;
use std::collections::HashSet;
use terrane_planet::draw::cut::Cut;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::query::KnownGround;

/// Bytes of main memory that the ground of a resident patch takes at most: heights, what selection knows of its index levels, and, where
/// cameras move, the triangles of those that a ray came near.
pub(super) fn bytes_of_patch(cells: u32, scope: Scope) -> u64 {
    let row = u64::from(cells) + 1;
    let bytes_of_sample = if scope == Scope::Still { 6 } else { 24 };
    bytes_of_sample * row * row + 16_384
}

/// Grids of the resident patches, and which of them are drawn.
pub struct DrawnGround {
    /// The finest ground that can be drawn.
    pub known: KnownGround,
    /// Patches of the latest cut.
    leaves: HashSet<PatchId>,
}

impl DrawnGround {
    /// Nothing is drawn yet of what is known.
    pub fn new(known: KnownGround) -> DrawnGround {
        DrawnGround { known, leaves: HashSet::new() }
    }

    /// Follows the latest cut.
    pub fn follow(&mut self, cut: &Cut) {
        self.leaves = cut.leaves.iter().map(|leaf| leaf.id).collect();
    }

    /// Metres above the datum that nothing drawn in a direction exceeds by more than the tolerance: the higher of what the latest cut
    /// has there and of the finest resident patches, which it may lack as long as their neighbours are missing. `None` if nothing is
    /// resident there.
    pub fn height_at(&self, direction: DVec3) -> Option<f64> {
        self.heights(direction).map(|[drawn, finest]| drawn.max(finest))
    }

    /// Whether a position, in planet-fixed metres, lies in the ground: below both.
    pub fn buries(&self, position: DVec3) -> bool {
        let lattice = &self.known.lattice;
        let height = position.length() - lattice.radius * lattice.unit;
        // The very centre lies in no direction, and in the ground.
        let direction = if position.length() > 0.0 { position } else { DVec3::X };
        self.heights(direction).is_some_and(|[drawn, finest]| height < drawn.min(finest))
    }

    /// Height of what the latest cut draws, and of the finest resident patches.
    fn heights(&self, direction: DVec3) -> Option<[f64; 2]> {
        let finest = self.known.height_at(direction)?;
        let mut drawn = Some(PatchId::containing(direction, finest.level));
        while let Some(id) = drawn.filter(|id| !self.leaves.contains(id)) {
            drawn = id.parent();
        }
        let coarser = drawn.filter(|id| id.level < finest.level);
        let drawn = coarser.and_then(|id| self.known.height_to_level(direction, id.level));
        Some([drawn.map_or(finest.height, |drawn| drawn.height), finest.height])
    }
}
