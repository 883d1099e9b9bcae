//! What a cost must offer to choose the edges that collapse first.

use super::outline::Room;
use glam::DVec3;

/// A place for the merger of an edge's two ends, with its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// What the collapse costs, at least 0.
    pub(super) cost: f64,
    /// Where the merger goes.
    pub(super) place: DVec3,
}

/// A cost of edge collapses that depends on nothing but the two ends of an edge.
pub(super) trait CollapseCost {
    /// Places to try for the merger of the ends a and b, which are at `places`; all within `room`.
    fn candidates(&self, ends: [u32; 2], places: [DVec3; 2], room: Room) -> Vec<Candidate>;

    /// Merges what is known of `other` into `vertex`.
    fn merge(&mut self, vertex: u32, other: u32);
}

impl Room {
    /// `place`, with what is pinned.
    pub(super) fn fit(self, place: DVec3) -> DVec3 {
        match self {
            Room::Place(only) => only,
            Room::Along(line, pins) => {
                DVec3::new(if pins.x() { line.x } else { place.x }, if pins.y() { line.y } else { place.y }, place.z)
            }
        }
    }

    /// Those of some places that lie in this room, at least one of them: both ends and points between them.
    pub(super) fn choose(self, places: [DVec3; 2], shares: &[f64]) -> Vec<DVec3> {
        let points = shares.iter().map(|&share| match share {
            // Ends to the bit.
            0.0 => places[0],
            1.0 => places[1],
            _ => places[0] + (places[1] - places[0]) * share,
        });
        match self {
            Room::Place(only) => vec![only],
            Room::Along(..) => points.filter(|&point| self.fit(point) == point).collect(),
        }
    }
}
