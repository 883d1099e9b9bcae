//! Border lines: what the vertices between two patches do follows from data that both patches can compute alone.
//!
//! A line is a straight row of samples on the cube surface. Its *canonical wakes* use only the samples on the line and one
//! row to either side (docs/design.md, "Borders"), in the direction of growing cube coordinates, so every patch that touches the
//! line, on this face or the next, computes the same bits.

mod strip;

use super::wake::{asked, Wake};
use crate::globe::patch::{PatchId, Side};
use crate::globe::sphere::{CubePoint, ONE};
use crate::ground::{Ground, HeightGrid, SurfacePoint};
use strip::Strip;

/// Lattice units by which a drawn point may lie off its ideal position, because vertices are rounded to the lattice. Part of
/// every measured error.
pub const ROUNDING: f64 = 1.0;

/// Lattice units by which the builder may measure the same chord's error differently: it works in the gnomonic plane, and
/// both computations round.
const CHORD_SLACK: f64 = 1e-2;

/// A border line: one side of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BorderLine {
    /// End with the smaller cube coordinate.
    pub origin: CubePoint,
    /// Cube axis it runs along.
    pub axis: usize,
}

impl BorderLine {
    /// The line along one side of a patch.
    pub fn of_side(id: PatchId, side: Side) -> BorderLine {
        let (u, v) = id.face.grid_axes();
        let high = i32::from(side.is_high());
        if side.is_horizontal() {
            BorderLine { origin: id.point(0, high, 1), axis: u }
        } else {
            BorderLine { origin: id.point(high, 0, 1), axis: v }
        }
    }

    /// Offsets of the rows on either side: on the face's plane, or down both faces where the line is a cube edge.
    fn row_offsets(&self, step: i32) -> [CubePoint; 2] {
        let (p, q) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let towards = |axis: usize, sign: i32| {
            let mut offset = CubePoint::ZERO;
            offset[axis] = sign * step;
            offset
        };
        let (at_p, at_q) = (self.origin[p], self.origin[q]);
        match (at_p.abs() == ONE, at_q.abs() == ONE) {
            (true, true) => [towards(p, -at_p.signum()), towards(q, -at_q.signum())],
            (true, false) => [towards(q, -1), towards(q, 1)],
            _ => [towards(p, -1), towards(p, 1)],
        }
    }

    /// Positions of `count + 1` samples of a level on the line, and of the rows beside it. What `grid` has of them is taken from there.
    fn sample(&self, ground: &Ground, grid: &HeightGrid, level: u8, count: usize) -> [Vec<SurfacePoint>; 3] {
        let step = ground.step(level);
        let [below, above] = self.row_offsets(step);
        let offsets = [CubePoint::ZERO, below, above];
        // Rows in turns: what is near on the ground is asked for together.
        let point = |k: usize| {
            let mut point = self.origin + offsets[k % 3];
            point[self.axis] = (i64::from(point[self.axis]) + (k / 3) as i64 * i64::from(step)) as i32;
            point
        };
        let points = ground.points_beside(grid, &(0..3 * (count + 1)).map(point).collect::<Vec<_>>());
        [0, 1, 2].map(|row| points.iter().skip(row).step_by(3).copied().collect())
    }

    /// The strips between the line and the rows of [`BorderLine::sample`], each on the face that holds it.
    fn strips(&self, [line, below, above]: &[Vec<SurfacePoint>; 3]) -> [Strip; 2] {
        let offsets = self.row_offsets(1);
        let faces = [0, 1].map(|k| (0..3).find(|&axis| axis != self.axis && offsets[k][axis] == 0).unwrap_or_default());
        [Strip::new(line, below, self.axis, faces[0]), Strip::new(line, above, self.axis, faces[1])]
    }

    /// Canonical wakes `W` of the line's first `count` cells at a level. The two ends are always awake. `grid` only saves samples: it is
    /// that of a patch beside the line, and no result depends on it.
    pub fn canonical_wakes(&self, ground: &Ground, grid: &HeightGrid, level: u8, count: usize, kappa: f64) -> Vec<Wake> {
        let rows = self.sample(ground, grid, level, count);
        let strips = self.strips(&rows);
        wakes_of_rows(&rows, &strips, self.first_index(ground, level), count / 2, kappa)
    }

    /// The largest wake, in lattice units, of the vertices that the next finer level has on the line and this one has not. They depend
    /// on few samples around each.
    pub fn child_wake(&self, ground: &Ground, grid: &HeightGrid, level: u8, kappa: f64) -> f64 {
        let wakes = |finer: u8| {
            let rows = self.sample(ground, grid, level + finer, (ground.cells as usize) << finer);
            wakes_of_rows(&rows, &self.strips(&rows), self.first_index(ground, level + finer), finer.into(), kappa)
        };
        let [own, finer] = [wakes(1), wakes(2)];
        (1..own.len()).step_by(2).map(|k| own[k].max(finer[2 * k]).distance()).fold(0.0, f64::max)
    }

    /// `V = max(W of this level, W of the next finer level)`: the wakes that both levels of patches along the line agree on. In: the
    /// line's canonical wakes at this level.
    pub fn shared_wakes(&self, ground: &Ground, grid: &HeightGrid, level: u8, canonical: &[Wake], kappa: f64) -> Vec<Wake> {
        let fine = self.canonical_wakes(ground, grid, level + 1, 2 * ground.cells as usize, kappa);
        canonical.iter().enumerate().map(|(k, &wake)| wake.max(fine[2 * k])).collect()
    }

    /// Index of the line's origin along its whole cube edge, in samples of a level.
    pub fn first_index(&self, ground: &Ground, level: u8) -> i64 {
        (i64::from(self.origin[self.axis]) + i64::from(ONE)) / i64::from(ground.step(level))
    }
}

/// Where sample `k` (counted along the whole cube edge, from 1) falls when it collapses: (target, other), the two samples that
/// it lies halfway between, the target being the one that lives longer.
pub fn targets(k: i64) -> (i64, i64) {
    let step = k & -k;
    if (k / step) % 4 == 1 {
        (k - step, k + step)
    } else {
        (k + step, k - step)
    }
}

/// Samples of the next row, to either side of a border vertex, that its fan may reach when it collapses at a step.
fn window(step: usize) -> usize {
    step / 3 + 1
}

/// Wakes of samples that collapse at steps up to `most_step`; the others have only what those ask of them, unrounded.
fn wakes_of_rows(rows: &[Vec<SurfacePoint>; 3], strips: &[Strip; 2], first: i64, most_step: usize, kappa: f64) -> Vec<Wake> {
    let line = &rows[0];
    let cells = line.len() - 1;
    let mut wanted = vec![0.0f64; cells + 1];
    let mut wakes = vec![Wake::ASLEEP; cells + 1];
    let mut step = 1;
    while step <= most_step {
        for b in (step..cells).step_by(2 * step) {
            let (a, c) = (b - step, b + step);
            let target = (targets(first + b as i64).0 - first) as usize;
            let rim = b - window(step).min(b)..=(b + window(step)).min(cells);
            let fans = strips.iter().map(|s| s.fan_error(target, rim.clone())).fold(0.0, f64::max);
            let error = chord_error(line, a, c).max(fans) + ROUNDING + CHORD_SLACK;
            let raw = error / kappa + reach(rows, b, step);
            wakes[b] = Wake::round_up(wanted[b].max(raw));
            for x in [a, c] {
                wanted[x] = wanted[x].max(asked(wakes[b].distance(), line[b].position.distance(line[x].position)));
            }
        }
        step *= 2;
    }
    wakes[0] = Wake::ALWAYS;
    wakes[cells] = Wake::ALWAYS;
    wakes
}

/// Largest radial distance of the samples strictly between `a` and `c` from the chord between them. Lines of constant cube
/// coordinate are great circles, so sample, chord and planet centre lie in one plane.
fn chord_error(line: &[SurfacePoint], a: usize, c: usize) -> f64 {
    let chord = line[c].ideal - line[a].ideal;
    let moment = line[a].ideal.cross(chord).length();
    (a + 1..c)
        .map(|i| {
            let radius = line[i].ideal.length();
            let drawn = moment * radius / line[i].ideal.cross(chord).length();
            (drawn - radius).abs()
        })
        .fold(0.0, f64::max)
}

/// Longest edge that a border vertex `b` may have when it collapses at this step: to its line neighbours, or to the vertices of
/// the next row within a third of the step.
fn reach(rows: &[Vec<SurfacePoint>; 3], b: usize, step: usize) -> f64 {
    let line = &rows[0];
    let window = window(step);
    let near = rows
        .iter()
        .flat_map(|row| &row[b.saturating_sub(window)..=(b + window).min(line.len() - 1)])
        .map(|q| q.position.distance(line[b].position))
        .fold(0.0, f64::max);
    let along = |other: usize| line[b].position.distance(line[other].position);
    near.max(along(b - step)).max(along(b + step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_multiples_of_four_steps() {
        for k in 1..1000i64 {
            let (target, other) = targets(k);
            let step = k & -k;
            assert_eq!(target % (4 * step), 0);
            assert_eq!(target + other, 2 * k);
        }
    }

    fn at(x: f64, y: f64, z: f64) -> SurfacePoint {
        let position = glam::DVec3::new(x, y, z);
        SurfacePoint { position, ideal: position }
    }

    #[test]
    fn a_bump_wakes_the_samples_around_it() {
        let mut rows = [0, 1, 2].map(|r| (0..=16).map(|i| at(f64::from(i), f64::from(r), 1e6)).collect::<Vec<_>>());
        let wakes = |rows: &[Vec<SurfacePoint>; 3]| {
            let strips = [1, 2].map(|k| Strip::new(&rows[0], &rows[k], 0, 2));
            wakes_of_rows(rows, &strips, 0, 8, 0.003)
        };
        let flat = wakes(&rows);
        rows[0][5] = at(5.0, 0.0, 1e6 + 3.0);
        let bumped = wakes(&rows);
        assert!(bumped[5] > flat[5] && bumped[4] > flat[4] && bumped[8] > flat[8]);
        assert_eq!(bumped[0], Wake::ALWAYS);
        assert_eq!(bumped[13], flat[13]);
    }
}
