//! Ground samples: heights over cube points, quantised to the lattice.

pub mod horizon;
mod kept;
mod normal;
pub mod surroundings;
pub mod texture;

pub use kept::{KeptHeights, SampledHeights};
pub use normal::NormalSite;

use crate::globe::lattice::Lattice;
use crate::globe::patch::PatchId;
use crate::globe::sphere::{direction, normalise, warp_component, CubePoint, Face};
use glam::{DVec3, IVec3};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Terrain as a pure function of direction. Implementations use only exactly rounded operations, so that every machine
/// computes the same bytes, and give the same bits however the directions are grouped into calls.
pub trait Elevation: Sync {
    /// Heights in metres above the datum for unit directions. `heights` is as long as `directions`.
    fn heights(&self, directions: &[DVec3], heights: &mut [f64]);
}

/// A point whose ground colour is asked for.
#[derive(Clone, Copy, Debug)]
pub struct GroundPoint {
    /// Unit direction.
    pub direction: DVec3,
    /// Height in metres above the datum.
    pub height: f64,
    /// Tangent of the slope angle.
    pub slope: f64,
    /// How much the ground rises a metre towards the north pole.
    pub north: f64,
    /// Metres between neighbouring points that are asked for: what is finer cannot be shown. 0 if there are none.
    pub spacing: f64,
}

/// Colour of bare ground as a pure function of direction, height and slope.
pub trait GroundColour: Sync {
    /// Metres above the sea of each point, below 0 where the sea covers it; nothing if there is no sea.
    fn above_sea(&self, _: &[GroundPoint]) -> Option<Vec<f64>> {
        None
    }

    /// sRGB-encoded albedo of each point.
    fn albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]);
}

/// Rows of texture samples beyond each side of a patch, in half cells (see [`self::texture`]).
pub const GUTTER: i32 = 4;

/// A point of the ground in lattice units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Exact lattice position: every component is a whole number. Distances are measured between these.
    pub position: DVec3,
    /// The same before rounding, exactly above its cube point. Errors are measured between these.
    pub ideal: DVec3,
}

/// A planet's terrain on its lattice, with the grid density of its patches.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Height function.
    pub elevation: &'a dyn Elevation,
    /// Lattice of the planet.
    pub lattice: Lattice,
    /// Grid cells along a patch side, a power of two.
    pub cells: u32,
    /// Heights known already, which save asking again.
    pub kept: Option<&'a KeptHeights>,
}

impl Ground<'_> {
    /// Quantised heights of directions.
    pub fn quantised(&self, directions: &[DVec3]) -> Vec<i32> {
        self.metres(directions).into_iter().map(|h| self.lattice.quantise_height(h)).collect()
    }

    /// Heights of directions in metres.
    pub fn metres(&self, directions: &[DVec3]) -> Vec<f64> {
        let mut heights = vec![0.0; directions.len()];
        self.elevation.heights(directions, &mut heights);
        heights
    }

    /// Points of the ground over cube points.
    pub fn points(&self, points: &[CubePoint]) -> Vec<SurfacePoint> {
        let directions: Vec<DVec3> = points.iter().map(|&p| direction(p)).collect();
        directions.iter().zip(self.quantised(&directions)).map(|(&d, h)| self.point(d, h)).collect()
    }

    /// The same, but heights of samples that `grid` has or its parent had are taken from there: the same bits without asking the terrain.
    pub fn points_beside(&self, grid: &HeightGrid, points: &[CubePoint]) -> Vec<SurfacePoint> {
        let known: Vec<Option<(DVec3, i32)>> = points.iter().map(|&point| self.known(grid, point)).collect();
        let is_unknown = |(&p, known): (&CubePoint, &Option<_>)| known.is_none().then(|| direction(p));
        let directions: Vec<DVec3> = points.iter().zip(&known).filter_map(is_unknown).collect();
        let mut asked = directions.iter().copied().zip(self.quantised(&directions));
        known.into_iter().filter_map(|known| known.or_else(|| asked.next())).map(|(d, h)| self.point(d, h)).collect()
    }

    /// Direction and quantised height of a sample that a grid has, or its parent had.
    fn known(&self, grid: &HeightGrid, point: CubePoint) -> Option<(DVec3, i32)> {
        if let Some(k) = grid.sampled.find(point) {
            return Some((grid.directions[k], grid.heights[k]));
        }
        let parent = grid.parent.as_ref()?;
        let metres = parent.metres[parent.find(point)?];
        Some((direction(point), self.lattice.quantise_height(metres)))
    }

    /// The point of the ground in a direction, at a quantised height.
    fn point(&self, direction: DVec3, height: i32) -> SurfacePoint {
        SurfacePoint {
            position: self.lattice.position(direction, height).as_dvec3(),
            ideal: direction * (self.lattice.radius + f64::from(height)),
        }
    }

    /// Cube units between neighbouring samples of a level (a level below the deepest is fine: half cells are whole units).
    pub fn step(&self, level: u8) -> i32 {
        ((1i64 << 31) / (i64::from(self.cells) << level)) as i32
    }
}

/// The directions of a patch's samples, with the warp evaluated once a column and once a row.
pub struct WarpedGrid {
    /// Warped face coordinates of the columns.
    pub columns: Vec<f64>,
    /// Warped face coordinates of the rows.
    pub rows: Vec<f64>,
    face: Face,
}

impl WarpedGrid {
    /// The samples of a patch at the given steps along both sides, `parts` steps being a whole side.
    pub fn new(id: PatchId, steps: RangeInclusive<i32>, parts: u32) -> WarpedGrid {
        let (u, v) = id.face.grid_axes();
        WarpedGrid {
            columns: steps.clone().map(|a| warp_component(id.point(a, 0, parts)[u])).collect(),
            rows: steps.map(|b| warp_component(id.point(0, b, parts)[v])).collect(),
            face: id.face,
        }
    }

    /// Unit direction of the sample in a column and a row, the same bits as [`direction`] of its cube point.
    #[inline(always)]
    pub fn direction(&self, column: usize, row: usize) -> DVec3 {
        let (u, v) = self.face.grid_axes();
        let mut point = [0.0; 3];
        point[u] = self.columns[column];
        point[v] = self.rows[row];
        point[self.face.normal_axis()] = f64::from(self.face.sign());
        normalise(point[0], point[1], point[2])
    }
}

/// The samples of a square grid in strips of a few rows, column by column, there and back in turns: any run of some tens of them lies
/// close together, which is what terrain is evaluated fastest for.
pub(crate) fn strips(side: usize) -> Vec<usize> {
    const ROWS: usize = 8;
    let strip = |first: usize| {
        let rows = first..(first + ROWS).min(side);
        let back = first / ROWS % 2 == 1;
        (0..side).flat_map(move |k| {
            let column = if back { side - 1 - k } else { k };
            rows.clone().map(move |row| row * side + column)
        })
    };
    (0..side).step_by(ROWS).flat_map(strip).collect()
}

/// Directions of a row of samples; wide instructions give the same bits, see [`crate::terrain`]. Each coordinate by itself first:
/// addresses in memory that take turns would keep the division from being vectorised.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn fill_directions(warped: &WarpedGrid, row: usize, directions: &mut [DVec3]) {
    const RUN: usize = 32;
    let (u, v) = warped.face.grid_axes();
    let mut point = [[f64::from(warped.face.sign()); RUN]; 3];
    point[v] = [warped.rows[row]; RUN];
    for (columns, directions) in warped.columns.chunks(RUN).zip(directions.chunks_mut(RUN)) {
        point[u][..columns.len()].copy_from_slice(columns);
        let [x, y, z] = &point;
        let mut found = [[0.0; RUN]; 3];
        for i in 0..RUN {
            let unit = normalise(x[i], y[i], z[i]);
            (found[0][i], found[1][i], found[2][i]) = (unit.x, unit.y, unit.z);
        }
        for (i, direction) in directions.iter_mut().enumerate() {
            *direction = DVec3::new(found[0][i], found[1][i], found[2][i]);
        }
    }
}

/// Heights in whole lattice units.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn quantise(lattice: &Lattice, metres: &[f64], heights: &mut [i32]) {
    for (height, &metres) in heights.iter_mut().zip(metres) {
        *height = lattice.quantise_height(metres);
    }
}

/// All height samples of one patch: every half cell of the patch and [`GUTTER`] half cells beyond each side.
pub struct HeightGrid {
    /// Whose samples these are.
    pub id: PatchId,
    /// Samples a side.
    pub side: usize,
    /// Heights in metres.
    pub sampled: SampledHeights,
    /// Those of the patch's parent, if they were known.
    pub parent: Option<SampledHeights>,
    /// The same in whole lattice units.
    pub heights: Vec<i32>,
    /// Directions of the samples, row by row.
    pub directions: Vec<DVec3>,
    /// Columns and rows of the samples.
    pub warped: WarpedGrid,
}

impl HeightGrid {
    /// Samples a patch.
    pub fn sample(ground: &Ground, id: PatchId) -> HeightGrid {
        let parts = 2 * ground.cells;
        let range = -GUTTER..=parts as i32 + GUTTER;
        let side = (parts as i32 + 2 * GUTTER + 1) as usize;
        let warped = WarpedGrid::new(id, range.clone(), parts);
        let mut directions = vec![DVec3::ZERO; side * side];
        for (row, directions) in directions.chunks_exact_mut(side).enumerate() {
            fill_directions(&warped, row, directions);
        }
        let kept = |id: PatchId| ground.kept.and_then(|kept| kept.get(id));
        let (own, parent) = (kept(id), id.parent().and_then(kept));
        let known = own.iter().chain(&parent);
        let metres = kept::sample_square(ground, known, id, (range, parts), |k| directions[k]);
        let mut heights = vec![0; side * side];
        quantise(&ground.lattice, &metres, &mut heights);
        let sampled = SampledHeights { id, side, metres: Arc::new(metres) };
        let grid = HeightGrid { id, side, sampled, parent, heights, directions, warped };
        if let Some(kept) = ground.kept.filter(|_| own.is_none()) {
            kept.keep(&grid);
        }
        grid
    }

    /// Index of the sample `a` half cells along and `b` half cells up from the patch's first corner.
    pub fn index(&self, a: i32, b: i32) -> usize {
        (b + GUTTER) as usize * self.side + (a + GUTTER) as usize
    }

    /// Quantised height of a half-cell sample.
    pub fn height(&self, a: i32, b: i32) -> i32 {
        self.heights[self.index(a, b)]
    }

    /// Lattice position of a half-cell sample.
    pub fn position(&self, lattice: &Lattice, a: i32, b: i32) -> IVec3 {
        let index = self.index(a, b);
        lattice.position(self.directions[index], self.heights[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::patch::Side;
    use std::sync::atomic::{AtomicUsize, Ordering};

    struct Waves;

    impl Elevation for Waves {
        fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
            for (height, d) in heights.iter_mut().zip(directions) {
                *height = 5e3 * (d.x * 31.0 - d.y * 17.0 + d.z * 23.0).fract();
            }
        }
    }

    #[test]
    fn points_beside_a_grid_are_those_of_the_terrain() {
        let ground = Ground { elevation: &Waves, lattice: Lattice::new(6e6, 1e4), cells: 8, kept: None };
        for id in Face::ALL
            .into_iter()
            .flat_map(|face| [(0, 0, 0), (2, 3, 0), (2, 1, 2), (21, 0, 77)].map(|(l, x, y)| PatchId::new(face, l, x, y)))
        {
            let id = id.unwrap();
            let grid = HeightGrid::sample(&ground, id);
            let steps = -GUTTER - 1..=16 + GUTTER + 1;
            let points: Vec<CubePoint> = steps.clone().flat_map(|b| steps.clone().map(move |a| id.point(a, b, 16))).collect();
            assert_eq!(points.iter().filter(|&&p| grid.sampled.find(p).is_some()).count(), grid.side * grid.side, "{id}");
            assert_eq!(ground.points_beside(&grid, &points), ground.points(&points), "{id}");
            let between = id.point(1, 1, 32);
            assert_eq!(grid.sampled.find(between), None, "{id}: between samples");
        }
    }

    /// Counts what it is asked for.
    struct Counted(AtomicUsize);

    impl Elevation for Counted {
        fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
            self.0.fetch_add(directions.len(), Ordering::Relaxed);
            Waves.heights(directions, heights);
        }
    }

    #[test]
    fn kept_heights_save_samples_and_change_none() {
        let (counted, kept) = (Counted(AtomicUsize::new(0)), KeptHeights::new(16));
        let bare = Ground { elevation: &Waves, lattice: Lattice::new(6e6, 1e4), cells: 16, kept: None };
        let ground = Ground { elevation: &counted, kept: Some(&kept), ..bare };
        let asked = || counted.0.swap(0, Ordering::Relaxed);
        for parent in
            Face::ALL.into_iter().flat_map(|face| [(0, 0, 0), (4, 15, 3)].map(|(l, x, y)| PatchId::new(face, l, x, y).unwrap()))
        {
            HeightGrid::sample(&ground, parent);
            for id in parent.children().unwrap() {
                asked();
                let (grid, plain) = (HeightGrid::sample(&ground, id), HeightGrid::sample(&bare, id));
                assert_eq!((&grid.sampled.metres, &grid.heights), (&plain.sampled.metres, &plain.heights), "{id}");
                assert_eq!(asked(), grid.side * grid.side - (grid.side / 2 + 1).pow(2), "{id}: the parent has every fourth");
                HeightGrid::sample(&ground, id);
                assert_eq!(asked(), 0, "{id}: all of its own are kept");
                let steps = -GUTTER - 1..=32 + GUTTER + 1;
                let points: Vec<CubePoint> = steps.clone().flat_map(|b| steps.clone().map(move |a| id.point(a, b, 16))).collect();
                assert_eq!(ground.points_beside(&grid, &points), bare.points(&points), "{id}");
            }
        }
    }

    #[test]
    fn a_grid_has_no_samples_of_the_other_face() {
        let ground = Ground { elevation: &Waves, lattice: Lattice::new(6e6, 1e4), cells: 8, kept: None };
        let id = PatchId::new(Face::ALL[0], 3, 7, 2).unwrap();
        let (grid, other) = (HeightGrid::sample(&ground, id), HeightGrid::sample(&ground, id.neighbour(Side::Right)));
        let inner: Vec<CubePoint> =
            (1..16).flat_map(|b| (1..16).map(move |a| (a, b))).map(|(a, b)| other.id.point(a, b, 16)).collect();
        assert!(inner.iter().all(|&p| grid.sampled.find(p).is_none() && other.sampled.find(p).is_some()));
    }
}
