//! Which patches an edit touches: all whose bytes may depend on the ground within its reach.
//!
//! A patch depends on more ground than it covers:
//!
//! * its texture's gutters, [`GUTTER`](crate::ground::GUTTER) half cells beyond each side: two cells, and so 2 √2 at its corners;
//! * the canonical wakes of its sides, on lines of its own level and of two finer ones: one cell to either side of the side;
//! * on sides that its parent shares, those of the *parent's* whole side, with one of the parent's cells to either side: two of its own.
//!
//! So: its square, and the sides of its parent that it lies on, all widened by [`MARGIN_CELLS`] of its cells.
//!
//! And it knows the ground by samples alone: an edit between all samples of a level changes no patch of that level. Those of a patch, its
//! borders and its parent's sides are among the points a quarter of its cell apart on the faces that they lie on, or beyond the edge of one
//! on its plane. So an edit touches only levels that have such a point within its reach: a crater of 100 m on an Earth hardly any of
//! the first six.
//!
//! In: edits and patch ids. Out: yes or no; a yes too many costs the time to build the same bytes again.

use crate::globe::patch::{PatchId, Side, MAX_LEVEL};
use crate::globe::sphere::{direction, warp_component, CubePoint, Face, ONE};
use crate::ground::surroundings::MARGIN;
use crate::recipe::Edit;
use crate::terrain::edits::centre;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Width of the margin in mean cells: 2 √2 cells, the largest of which is 3 % wider than the mean, and some room for rounding.
const MARGIN_CELLS: f64 = 3.2;

/// The same of the surroundings: √2 times their margin.
const AROUND_CELLS: f64 = 1.5 * MARGIN as f64;

/// Samples of a patch are at most so many to a cell apart, those of its borders included.
const SAMPLES_A_CELL: u32 = 4;

/// Most points a side that are looked at for one within reach; where there are more there is one.
const MOST_LOOKED_AT: i64 = 12;

/// By how much a cube coordinate changes along a chord at most: 2.3 in the farthest corner that is looked at.
const STEEPEST: f64 = 3.0;

/// In cube coordinates, how far beyond a face's edges its plane's samples are looked at. Farther out there is one within reach.
const FARTHEST_BEYOND: f64 = 0.25;

/// By how much reaches are widened, so that no rounding lets a sample seem out of reach: a share of them, and a chord.
const ROOM: f64 = 1e-6;
const ROUNDING: f64 = 1e-12;

/// The ground within reach of one edit.
#[derive(Clone, Debug)]
pub struct Touched {
    centre: DVec3,
    /// As a chord of the unit sphere.
    reach: f64,
    cells: u32,
    /// By level, whether a sample of its patches, and one of their surroundings, may be within reach.
    sampled: Vec<[bool; 2]>,
}

impl Touched {
    /// Of an edit on a planet of `planet_m` metres radius, whose patches have `cells` cells a side.
    pub fn new(edit: &Edit, planet_m: f64, cells: u32) -> Touched {
        let centre = centre(edit.latitude_deg, edit.longitude_deg);
        let mut touched = Touched { centre, reach: edit.reach_m() / planet_m, cells, sampled: Vec::new() };
        let of_level = |level| {
            // Borders are also those of the parent, whose cells are twice as large.
            let (own, around) = ((SAMPLES_A_CELL, 2.0 * MARGIN_CELLS), (1, AROUND_CELLS));
            [own, around].map(|samples| Face::ALL.into_iter().any(|face| touched.meets_sample(face, level, samples)))
        };
        touched.sampled = (0..=MAX_LEVEL).map(of_level).collect();
        touched
    }

    /// Whether one of the samples of a face's patches of a level may be within reach: so many to a cell, on the face and on its plane up to
    /// so many cells beyond its edges.
    fn meets_sample(&self, face: Face, level: u8, (samples, margin): (u32, f64)) -> bool {
        if self.centre.dot(face.normal()) <= 0.0 {
            return false;
        }
        let (a, b) = face.coordinates(self.centre);
        let cell = 2.0 / f64::from(self.cells) / f64::from(1u32 << level);
        let off = STEEPEST * self.reach;
        let beyond = a.abs().max(b.abs()) - 1.0;
        if beyond > off + margin * cell {
            return false;
        }
        let step = (2 * i64::from(ONE) / i64::from(self.cells * samples)) >> level;
        if beyond + off > FARTHEST_BEYOND || step == 0 {
            return true;
        }
        // From a face's corner on, which is a sample of every level.
        let units = |coordinate: f64| (coordinate + 1.0) * f64::from(ONE) / step as f64;
        let range = |coordinate: f64| units(coordinate - off).floor() as i64..=units(coordinate + off).ceil() as i64;
        let (columns, rows) = (range(a), range(b));
        if [&columns, &rows].into_iter().any(|range| range.end() - range.start() > MOST_LOOKED_AT) {
            return true;
        }
        let (u, v) = face.grid_axes();
        let is_reached = |column: i64, row: i64| {
            let mut point = CubePoint::ZERO;
            point[u] = (column * step - i64::from(ONE)) as i32;
            point[v] = (row * step - i64::from(ONE)) as i32;
            point[face.normal_axis()] = face.sign() * ONE;
            direction(point).distance(self.centre) <= self.reach * (1.0 + ROOM) + ROUNDING
        };
        rows.into_iter().any(|row| columns.clone().any(|column| is_reached(column, row)))
    }

    /// Whether a patch may depend on that ground.
    pub fn touches(&self, id: PatchId) -> bool {
        if !self.sampled[usize::from(id.level)][0] {
            return false;
        }
        let near = self.near(id, MARGIN_CELLS);
        let mut parents = Side::ALL.into_iter().filter(|&side| id.on_parent_boundary(side));
        self.reaches(id, near)
            || id.parent().is_some_and(|parent| parents.any(|side| self.distance_to_side(parent, side) <= near))
    }

    /// Whether the surroundings of a patch depend on it.
    pub fn touches_around(&self, id: PatchId) -> bool {
        self.sampled[usize::from(id.level)][1] && self.reaches(id, self.near(id, AROUND_CELLS))
    }

    /// How near the edit's middle is to all that it reaches, and so many of a patch's cells beyond.
    fn near(&self, id: PatchId, cells: f64) -> f64 {
        self.reach + cells * FRAC_PI_2 / f64::from(1u32 << id.level) / f64::from(self.cells)
    }

    /// Whether the edit's middle lies in a patch, or that near to one of its sides.
    fn reaches(&self, id: PatchId, near: f64) -> bool {
        self.is_inside(id) || Side::ALL.into_iter().any(|side| self.distance_to_side(id, side) <= near)
    }

    fn is_inside(&self, id: PatchId) -> bool {
        let (low, high) = (id.point(0, 0, 1), id.point(1, 1, 1));
        let (u, v) = id.face.grid_axes();
        let (a, b) = id.face.project(self.centre);
        let within = |x: f64, axis: usize| (warp_component(low[axis])..=warp_component(high[axis])).contains(&x);
        self.centre.dot(id.face.normal()) > 0.0 && within(a, u) && within(b, v)
    }

    /// At most the distance, as a chord, of the edit's middle from a side. Sides are arcs of great circles; how far such an arc rises
    /// over the straight way between its ends is taken off.
    fn distance_to_side(&self, id: PatchId, side: Side) -> f64 {
        let high = i32::from(side.is_high());
        let end = |k: i32| direction(if side.is_horizontal() { id.point(k, high, 1) } else { id.point(high, k, 1) });
        let (from, to) = (end(0), end(1));
        let along = to - from;
        let share = ((self.centre - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let half = 0.5 * along.length();
        let rise = 1.0 - (1.0 - half * half).sqrt();
        self.centre.distance(from + along * share) - rise
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::latitude_longitude;
    use crate::recipe::Shape;
    use glam::IVec3;

    fn touched(site: DVec3, radius_m: f64) -> Touched {
        let (latitude_deg, longitude_deg) = latitude_longitude(site);
        Touched::new(&Edit { latitude_deg, longitude_deg, radius_m, shape: Shape::Raise { by_m: 1.0 } }, 1e6, 16)
    }

    fn all(level: u8) -> impl Iterator<Item = PatchId> {
        let count = 1u32 << level;
        let tile = move |k: u32| (k % count, k / count);
        Face::ALL
            .into_iter()
            .flat_map(move |face| (0..count * count).filter_map(move |k| PatchId::new(face, level, tile(k).0, tile(k).1)))
    }

    #[test]
    fn a_small_edit_touches_a_few_patches() {
        for level in 0..6 {
            let inside = all(level).nth((1 << level) / 2).unwrap();
            let middle = touched(inside.centre(), 10.0);
            assert!(middle.touches(inside), "{inside}");
            let count = all(level).filter(|&id| middle.touches(id)).count();
            assert!(count <= 9, "{count} patches of level {level}");
        }
    }

    #[test]
    fn an_edit_between_all_samples_of_a_level_touches_no_patch_of_it() {
        let inside = all(4).find(|id| (id.x, id.y) == (7, 6)).unwrap();
        // Amid a quarter of a cell, and on a sample of its middle.
        let (between, on) = (direction(inside.point(5, 7, 128)), direction(inside.point(2, 3, 64)));
        let radius_m = 0.2 * std::f64::consts::FRAC_PI_2 * 1e6 / f64::from((4 * 16) << 4);
        for (site, expected) in [(between, false), (on, true)] {
            let small = touched(site, radius_m);
            assert_eq!((small.touches(inside), small.touches(inside.parent().unwrap())), (expected, false));
            let nearest = PatchId::containing(site, 5);
            assert!(small.touches(nearest) && !small.touches_around(inside));
            assert!(touched(site, 5.0 * radius_m).touches(inside));
        }
    }

    #[test]
    fn an_edit_at_a_corner_touches_the_patches_around_it() {
        // A corner of the cube belongs to three patches; the lines that meet there belong to other children of their parents too.
        let corner = touched(direction(IVec3::new(ONE, ONE, ONE)), 1.0);
        for level in 1..6 {
            let found: Vec<PatchId> = all(level).filter(|&id| corner.touches(id)).collect();
            let at_corner = |id: &&PatchId| (id.centre() - DVec3::ONE.normalize()).length() < 1.2 / f64::from(1u32 << level);
            assert!(found.iter().filter(at_corner).count() >= 3, "level {level}: {found:?}");
            assert!(found.len() <= 24, "level {level}: {}", found.len());
        }
    }
}
