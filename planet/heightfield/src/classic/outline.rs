//! What keeps a heightfield's rectangle covered while it is simplified: vertices on its sides stay on their side, and corners
//! stay. In: a heightfield. Out: for each of its vertices which coordinates are pinned, and where merged ones may go.

use crate::Heightfield;
use glam::DVec3;

/// Coordinates that may not change: bit 0 for x, bit 1 for y. Corners have both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Pins(u8);

impl Pins {
    /// A vertex of a western or eastern side.
    const X: u8 = 1;
    /// A vertex of a southern or northern side.
    const Y: u8 = 2;

    /// Whether x is pinned.
    pub(super) fn x(self) -> bool {
        self.0 & Pins::X != 0
    }

    /// Whether y is pinned.
    pub(super) fn y(self) -> bool {
        self.0 & Pins::Y != 0
    }

    /// Whether this is on the outline.
    pub(super) fn on_outline(self) -> bool {
        self.0 != 0
    }

    fn is_corner(self) -> bool {
        self.0 == Pins::X | Pins::Y
    }
}

/// Pins of all vertices.
pub(super) struct Outline {
    pins: Vec<Pins>,
}

/// Where the merger of two vertices may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Room {
    /// Only this position.
    Point(DVec3),
    /// Anywhere that has the pinned coordinates of this position.
    Along(DVec3, Pins),
}

impl Outline {
    /// The outline of the full mesh of a heightfield.
    pub(super) fn of(field: &Heightfield) -> Outline {
        let (columns, rows) = (field.columns(), field.rows());
        let pins = (0..columns * rows).map(|sample| {
            let x = [0, columns - 1].contains(&(sample % columns));
            let y = [0, rows - 1].contains(&(sample / columns));
            Pins(u8::from(x) * Pins::X + u8::from(y) * Pins::Y)
        });
        Outline { pins: pins.collect() }
    }

    /// Pins of a vertex.
    pub(super) fn pins(&self, vertex: u32) -> Pins {
        self.pins[vertex as usize]
    }

    /// Whether `vertex` may collapse into `into`, which stays where it is: only if that lies on all sides that `vertex` lies on.
    /// (Two sides are told apart by the link condition: an edge from west to east crosses the field.)
    pub(super) fn may_fall(&self, vertex: u32, into: u32) -> bool {
        let (from, to) = (self.pins(vertex).0, self.pins(into).0);
        from & to == from && from != Pins::X | Pins::Y
    }

    /// Where the merger of `a` and `b` may go; `None` if it would leave a side or a corner.
    pub(super) fn room(&self, [a, b]: [u32; 2], positions: [DVec3; 2]) -> Option<Room> {
        let [pins_a, pins_b] = [self.pins(a), self.pins(b)];
        if pins_a.is_corner() || pins_b.is_corner() {
            let (corner, position, other) = if pins_a.is_corner() { (a, positions[0], b) } else { (b, positions[1], a) };
            return self.may_fall(other, corner).then_some(Room::Point(position));
        }
        match (pins_a.0, pins_b.0) {
            (_, 0) => Some(Room::Along(positions[0], pins_a)),
            (0, _) => Some(Room::Along(positions[1], pins_b)),
            (x, y) if x == y => Some(Room::Along(positions[0], pins_a)),
            _ => None,
        }
    }

    /// Gives `vertex` the pins of both: those of the merger.
    pub(super) fn merge(&mut self, vertex: u32, other: u32) {
        self.pins[vertex as usize].0 |= self.pins[other as usize].0;
    }
}
