//! Patches: squares of the six quadtrees, their sample grids and their neighbours.

use super::sphere::{CubePoint, Face, ONE};
use glam::DVec3;
use std::fmt;

/// Most grid cells along a patch side that vertex numbers (15 bits in a packed triangle) allow.
pub const MAX_CELLS: u32 = 128;
/// Fewest cells a side for which corner, mid-edge and quarter points are distinct.
pub const MIN_CELLS: u32 = 8;
/// Deepest quadtree level: texture samples (half cells of the level below) still fall on whole cube coordinates.
pub const MAX_LEVEL: u8 = 21;

/// Name of a patch: face, level (0 is a whole face), and column and row below 2^level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatchId {
    /// Face of the cube.
    pub face: Face,
    /// Quadtree level.
    pub level: u8,
    /// Column, along the face's first grid axis.
    pub x: u32,
    /// Row, along the face's second grid axis.
    pub y: u32,
}

/// The four sides of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// i = 0.
    Left,
    /// i = n.
    Right,
    /// j = 0.
    Bottom,
    /// j = n.
    Top,
}

impl Side {
    /// All sides, in bit order of [`Side::bit`].
    pub const ALL: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];

    /// One bit a side.
    pub fn bit(self) -> u8 {
        1 << self as u8
    }

    /// Whether the side runs along the first grid axis.
    pub fn is_horizontal(self) -> bool {
        matches!(self, Side::Bottom | Side::Top)
    }

    /// Whether the side lies at the high end of its axis.
    pub fn is_high(self) -> bool {
        matches!(self, Side::Right | Side::Top)
    }
}

impl PatchId {
    /// The six whole faces.
    pub fn roots() -> impl Iterator<Item = PatchId> {
        Face::ALL.into_iter().map(|face| PatchId { face, level: 0, x: 0, y: 0 })
    }

    /// A patch id, if level, column and row are in range.
    pub fn new(face: Face, level: u8, x: u32, y: u32) -> Option<PatchId> {
        (level <= MAX_LEVEL && x < 1 << level && y < 1 << level).then_some(PatchId { face, level, x, y })
    }

    /// The patch one level up that contains this one.
    pub fn parent(self) -> Option<PatchId> {
        (self.level > 0).then(|| PatchId { face: self.face, level: self.level - 1, x: self.x / 2, y: self.y / 2 })
    }

    /// The patch of a coarser level (or its own) that contains this one.
    pub fn ancestor(self, level: u8) -> PatchId {
        let up = self.level.saturating_sub(level);
        PatchId { face: self.face, level: self.level - up, x: self.x >> up, y: self.y >> up }
    }

    /// The four patches one level down, or none past [`MAX_LEVEL`].
    pub fn children(self) -> Option<[PatchId; 4]> {
        (self.level < MAX_LEVEL).then(|| {
            [0, 1, 2, 3].map(|k| PatchId {
                face: self.face,
                level: self.level + 1,
                x: 2 * self.x + (k & 1),
                y: 2 * self.y + (k >> 1),
            })
        })
    }

    /// Which of its parent's children it is, in the order of [`PatchId::children`].
    pub fn quarter(self) -> usize {
        (self.x % 2 + 2 * (self.y % 2)) as usize
    }

    /// Length of a side in cube units.
    pub fn size(self) -> i32 {
        // A whole face is 2^31 wide, one more than i32 holds: level 0 is only ever used halved or in i64.
        (1i64 << (31 - self.level)).min(i64::from(i32::MAX)) as i32
    }

    /// The cube point `a` of `parts` along the first and `b` of `parts` along the second axis. `parts` must divide the side in
    /// cube units; `a` and `b` may leave 0..=parts by a few steps (rows beyond the side).
    pub fn point(self, a: i32, b: i32, parts: u32) -> CubePoint {
        let step = (1i64 << (31 - self.level)) / i64::from(parts);
        let at = |tile: u32, k: i32| -i64::from(ONE) + i64::from(tile) * (1i64 << (31 - self.level)) + i64::from(k) * step;
        let (u, v) = self.face.grid_axes();
        let mut point = CubePoint::ZERO;
        point[u] = at(self.x, a) as i32;
        point[v] = at(self.y, b) as i32;
        point[self.face.normal_axis()] = self.face.sign() * ONE;
        point
    }

    /// The patch of the same level across a side, on this or the adjoining face.
    pub fn neighbour(self, side: Side) -> PatchId {
        let last = (1u32 << self.level) - 1;
        let across = match side {
            Side::Left if self.x > 0 => Some((self.x - 1, self.y)),
            Side::Right if self.x < last => Some((self.x + 1, self.y)),
            Side::Bottom if self.y > 0 => Some((self.x, self.y - 1)),
            Side::Top if self.y < last => Some((self.x, self.y + 1)),
            _ => None,
        };
        match across {
            Some((x, y)) => PatchId { x, y, ..self },
            None => self.neighbour_over_edge(side),
        }
    }

    fn neighbour_over_edge(self, side: Side) -> PatchId {
        let (u, v) = self.face.grid_axes();
        let (leaving, along, index) = if side.is_horizontal() { (v, u, self.x) } else { (u, v, self.y) };
        let face = Face::of_axis(leaving, side.is_high());
        // On the new face our old normal axis is a grid axis, and we enter at its end on our side.
        let entry = if self.face.sign() > 0 { (1u32 << self.level) - 1 } else { 0 };
        let (nu, _) = face.grid_axes();
        if nu == along {
            PatchId { face, level: self.level, x: index, y: entry }
        } else {
            PatchId { face, level: self.level, x: entry, y: index }
        }
    }

    /// Whether a side lies on the boundary of the parent patch (never for level 0).
    pub fn on_parent_boundary(self, side: Side) -> bool {
        let odd = if side.is_horizontal() { self.y } else { self.x } % 2 == 1;
        self.level > 0 && odd == side.is_high()
    }

    /// The patch of a level that a direction falls in.
    pub fn containing(direction: DVec3, level: u8) -> PatchId {
        let face = Face::containing(direction);
        let (a, b) = face.coordinates(direction);
        let count = 1u32 << level;
        let tile = |c: f64| (((c + 1.0) / 2.0 * f64::from(count)) as u32).min(count - 1);
        PatchId { face, level, x: tile(a), y: tile(b) }
    }

    /// Direction of the patch's middle.
    pub fn centre(self) -> DVec3 {
        super::sphere::direction(self.point(1, 1, 2))
    }
}

impl fmt::Display for PatchId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"][usize::from(self.face.index())];
        write!(f, "{name}/{}/{}/{}", self.level, self.x, self.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(level: u8) -> impl Iterator<Item = PatchId> {
        let count = 1u32 << level;
        Face::ALL
            .into_iter()
            .flat_map(move |face| (0..count * count).map(move |k| PatchId { face, level, x: k % count, y: k / count }))
    }

    fn side_points(id: PatchId, side: Side) -> Vec<CubePoint> {
        let n = 8;
        (0..=n)
            .map(|k| match side {
                Side::Left => id.point(0, k, n as u32),
                Side::Right => id.point(n, k, n as u32),
                Side::Bottom => id.point(k, 0, n as u32),
                Side::Top => id.point(k, n, n as u32),
            })
            .collect()
    }

    #[test]
    fn neighbours_share_exactly_one_side() {
        for id in all(2).chain(all(0)) {
            for side in Side::ALL {
                let other = id.neighbour(side);
                let ours = side_points(id, side);
                let matching = Side::ALL.into_iter().filter(|&s| side_points(other, s) == ours).count();
                assert_eq!(matching, 1, "{id} {side:?} -> {other}");
            }
        }
    }

    #[test]
    fn parents_and_children_share_samples() {
        for id in all(1) {
            for (k, child) in id.children().unwrap().into_iter().enumerate() {
                assert_eq!(child.parent(), Some(id));
                let (ox, oy) = ((k as i32 & 1) * 4, (k as i32 >> 1) * 4);
                for j in 0..=4 {
                    for i in 0..=4 {
                        assert_eq!(id.point(ox + i, oy + j, 8), child.point(2 * i, 2 * j, 8));
                    }
                }
            }
        }
    }

    #[test]
    fn a_patch_contains_its_own_centre() {
        for id in all(3) {
            assert_eq!(PatchId::containing(id.centre(), 3), id);
        }
    }
}
