//! What a cost must offer to choose the edges that collapse first.

use super::outline::Room;
use glam::DVec3;

/// A position for the merger of an edge's two ends, with its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// What the collapse costs, at least 0.
    pub(super) cost: f64,
    /// Where the merger goes.
    pub(super) position: DVec3,
}

/// A cost of edge collapses that depends on nothing but the two ends of an edge.
pub(super) trait CollapseCost {
    /// Positions to try for the merger of the ends a and b, which are at `positions`; all within `room`.
    fn candidates(&self, ends: [u32; 2], positions: [DVec3; 2], room: Room) -> Vec<Candidate>;

    /// Merges what is known of `other` into `vertex`.
    fn merge(&mut self, vertex: u32, other: u32);
}

impl Room {
    /// `position`, with what is pinned.
    pub(super) fn fit(self, position: DVec3) -> DVec3 {
        match self {
            Room::Point(only) => only,
            Room::Along(line, pins) => {
                DVec3::new(if pins.x() { line.x } else { position.x }, if pins.y() { line.y } else { position.y }, position.z)
            }
        }
    }

    /// Those of some positions that lie in this room, at least one of them: both ends and points between them.
    pub(super) fn choose(self, positions: [DVec3; 2], shares: &[f64]) -> Vec<DVec3> {
        let points = shares.iter().map(|&share| match share {
            // Ends to the bit.
            0.0 => positions[0],
            1.0 => positions[1],
            _ => positions[0] + (positions[1] - positions[0]) * share,
        });
        match self {
            Room::Point(only) => vec![only],
            Room::Along(..) => points.filter(|&point| self.fit(point) == point).collect(),
        }
    }
}
