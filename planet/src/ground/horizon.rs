//! Shadows and ambient light of the relief: how high the ground around every vertex of a patch rises towards the sun, and how much of
//! the sky it leaves. Horizon mapping (Max 1988) along the one azimuth that counts, from the terrain and never from the mesh.
//!
//! In: a patch and the sun. Out: [`HorizonMap`]. What lies up to 8 cells away is looked up in samples as dense as the patch's own, what
//! lies up to 16 in those of its parent's density, and so on: which samples count follows from the distance alone, so that neighbours
//! of one level agree where they meet.

use super::kept::{sample_square, SampledHeights};
use super::{Ground, WarpedGrid};
use crate::globe::patch::PatchId;
use crate::globe::patch_cache::PatchCache;
use glam::DVec3;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Samples known beyond each side of a patch, in cells: no look-up goes farther in its own density.
const MARGIN: i32 = 10;

/// Cells away, in a patch's own density.
const NEAR: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// Cells away in every coarser density: the next octave of distance.
const FAR: [f64; 6] = [4.5, 5.1, 5.7, 6.4, 7.2, 8.0];

/// Coarser densities that are looked up for every vertex; those beyond change so slowly that every fourth vertex will do.
const FINE_LEVELS: u8 = 2;

/// Vertices between those that look far.
const COARSE_STEP: usize = 4;

/// Azimuths around a vertex along which the sky is measured, and cells away in the densities of [`SKY_LEVELS`].
const SKY_AZIMUTHS: usize = 8;
const SKY_NEAR: [f64; 3] = [2.0, 4.0, 7.0];
const SKY_LEVELS: u8 = 4;

/// Coarsest level that is looked up: whole faces have no straight lines.
const COARSEST: u8 = 2;

/// Radians beyond which no mountain of a planet's size stands out any more.
const FARTHEST: f64 = 0.12;

/// Grids kept by [`WideGrids`], of some 30 kB each at 64 cells a side.
const MOST_GRIDS: usize = 1024;

/// Heights around a patch.
pub struct WideGrid {
    warped: WarpedGrid,
    side: usize,
    metres: Vec<f32>,
}

impl WideGrid {
    /// Samples a patch and its surroundings.
    pub fn sample(ground: &Ground, id: PatchId) -> WideGrid {
        let steps = -MARGIN..=ground.cells as i32 + MARGIN;
        let warped = WarpedGrid::new(id, steps.clone(), ground.cells);
        let side = warped.columns.len();
        let known: Vec<SampledHeights> =
            ground.kept.map_or_else(Vec::new, |kept| id.parent().into_iter().chain([id]).filter_map(|id| kept.get(id)).collect());
        let direction = |k: usize| warped.direction(k % side, k / side);
        let metres = sample_square(ground, &known, id, (steps, ground.cells), direction);
        let metres = metres.into_iter().map(|height| height as f32).collect();
        WideGrid { warped, side, metres }
    }

    /// The height at a point in cells from the patch's first corner, between samples bilinearly.
    #[inline(always)]
    fn height(&self, x: f32, y: f32) -> f32 {
        let most = (self.side - 2) as f32;
        let (x, y) = ((x + MARGIN as f32).clamp(0.0, most), (y + MARGIN as f32).clamp(0.0, most));
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f32, y - row as f32);
        let at = row * self.side + column;
        let (low, high) = (&self.metres[at..at + 2], &self.metres[at + self.side..at + self.side + 2]);
        let (low, high) = (low[0] + (low[1] - low[0]) * u, high[0] + (high[1] - high[0]) * u);
        low + (high - low) * v
    }
}

/// Heights around patches, those used latest kept: siblings share all their ancestors.
pub struct WideGrids {
    kept: Mutex<PatchCache<Arc<WideGrid>>>,
}

impl Default for WideGrids {
    fn default() -> WideGrids {
        WideGrids { kept: Mutex::new(PatchCache::new(MOST_GRIDS)) }
    }
}

impl WideGrids {
    /// The heights around a patch.
    pub fn get(&self, ground: &Ground, id: PatchId) -> Arc<WideGrid> {
        if let Some(grid) = self.lock().get(id) {
            return grid;
        }
        // Two threads may sample the same patch: they get the same heights.
        let grid = Arc::new(WideGrid::sample(ground, id));
        self.lock().insert(id, grid.clone());
        grid
    }

    fn lock(&self) -> MutexGuard<'_, PatchCache<Arc<WideGrid>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Horizon angles and ambient occlusion at the vertices of a patch, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct HorizonMap {
    /// Sine of the elevation of the horizon towards the sun: ground there hides whatever is lower. Below 0 where the ground falls away.
    pub horizon: Vec<f32>,
    /// Share of the light of an even sky that reaches level ground, 0 to 1.
    pub sky: Vec<f32>,
}

impl HorizonMap {
    /// The map of a patch. `sun` is a unit vector.
    pub fn new(ground: &Ground, grids: &WideGrids, id: PatchId, sun: DVec3) -> HorizonMap {
        let radius = (ground.lattice.radius * ground.lattice.unit) as f32;
        let chain = Chain::new(ground, grids, id, radius);
        let row = ground.cells as usize + 1;
        let coarse = |k: usize| k.div_ceil(COARSE_STEP) + 1;
        let coarse_row = coarse(row - 1);
        let (mut far, mut open) = (vec![0.0; coarse_row * coarse_row], vec![0.0; coarse_row * coarse_row]);
        for (k, (far, open)) in far.iter_mut().zip(&mut open).enumerate() {
            let [x, y] = [k % coarse_row, k / coarse_row].map(|c| (COARSE_STEP * c).min(row - 1));
            let vertex = chain.vertex(x, y);
            *far = chain.far_horizon(&vertex, vertex.towards(sun));
            *open = chain.sky(&vertex);
        }
        let between = |values: &[f32], x: usize, y: usize| {
            let (column, line) = (x / COARSE_STEP, y / COARSE_STEP);
            let (u, v) = ((x % COARSE_STEP) as f32 / COARSE_STEP as f32, (y % COARSE_STEP) as f32 / COARSE_STEP as f32);
            let at = |x: usize, y: usize| values[y.min(coarse_row - 1) * coarse_row + x.min(coarse_row - 1)];
            let (low, high) = ([at(column, line), at(column + 1, line)], [at(column, line + 1), at(column + 1, line + 1)]);
            let (low, high) = (low[0] + (low[1] - low[0]) * u, high[0] + (high[1] - high[0]) * u);
            low + (high - low) * v
        };
        let mut map = HorizonMap { horizon: Vec::with_capacity(row * row), sky: Vec::with_capacity(row * row) };
        for (x, y) in (0..row).flat_map(|y| (0..row).map(move |x| (x, y))) {
            let vertex = chain.vertex(x, y);
            let tangent = chain.near_horizon(&vertex, vertex.towards(sun)).max(between(&far, x, y));
            map.horizon.push(tangent / (1.0 + tangent * tangent).sqrt());
            map.sky.push(between(&open, x, y));
        }
        map
    }
}

/// A vertex and how its surroundings lie in the grid.
struct GridVertex {
    /// Cells from the patch's first corner.
    grid: [f32; 2],
    height: f32,
    up: DVec3,
    /// How the direction changes from cell to cell along both sides.
    axes: [DVec3; 2],
}

/// A way from a vertex: cells along both sides a cell of distance, and that distance in radians.
#[derive(Clone, Copy)]
struct Way {
    step: [f32; 2],
    radians: f32,
}

impl GridVertex {
    /// The way along the ground towards a direction; any if it is straight above.
    fn towards(&self, target: DVec3) -> Way {
        let tangent = target - self.up * target.dot(self.up);
        let tangent = tangent.try_normalize().unwrap_or(self.axes[0].normalize());
        let [a, b] = self.axes;
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let (at, bt) = (a.dot(tangent), b.dot(tangent));
        let determinant = aa * bb - ab * ab;
        let (p, q) = ((bb * at - ab * bt) / determinant, (aa * bt - ab * at) / determinant);
        let cells = (p * p + q * q).sqrt();
        Way { step: [(p / cells) as f32, (q / cells) as f32], radians: (1.0 / cells) as f32 }
    }
}

/// The heights around a patch and around its ancestors, the patch's own first.
struct Chain {
    grids: Vec<Arc<WideGrid>>,
    /// Where the patch's first corner lies in each of them, in cells, and how many of the patch's cells one of theirs is.
    corners: Vec<([f32; 2], f32)>,
    radius: f32,
}

impl Chain {
    fn new(ground: &Ground, grids: &WideGrids, id: PatchId, radius: f32) -> Chain {
        let cell = std::f64::consts::FRAC_PI_2 / f64::from(ground.cells) / f64::from(1u32 << id.level);
        let mut chain = Chain { grids: Vec::new(), corners: Vec::new(), radius };
        let mut at = Some(id);
        while let Some(ancestor) = at {
            let up = id.level - ancestor.level;
            let scale = f64::from(1u32 << up);
            if up > 0 && (ancestor.level < COARSEST || cell * scale * NEAR[NEAR.len() - 1] / 2.0 > FARTHEST) {
                break;
            }
            let corner = |own: u32, theirs: u32| f64::from(own - (theirs << up)) * f64::from(ground.cells) / scale;
            chain.grids.push(grids.get(ground, ancestor));
            chain.corners.push(([corner(id.x, ancestor.x) as f32, corner(id.y, ancestor.y) as f32], scale as f32));
            at = ancestor.parent();
        }
        chain
    }

    fn vertex(&self, x: usize, y: usize) -> GridVertex {
        let own = &self.grids[0];
        let (column, row) = (x + MARGIN as usize, y + MARGIN as usize);
        let direction = |column: usize, row: usize| own.warped.direction(column, row);
        let along = (direction(column + 1, row) - direction(column - 1, row)) * 0.5;
        let across = (direction(column, row + 1) - direction(column, row - 1)) * 0.5;
        let height = own.metres[row * own.side + column];
        GridVertex { grid: [x as f32, y as f32], height, up: direction(column, row), axes: [along, across] }
    }

    /// Tangent of the elevation at which a vertex sees the ground so many cells away, in the density of the `k`th grid.
    #[inline(always)]
    fn tangent(&self, k: usize, vertex: &GridVertex, way: Way, cells: f64) -> f32 {
        let ([x, y], scale) = self.corners[k];
        let cells = cells as f32;
        let height = self.grids[k]
            .height(x + vertex.grid[0] / scale + way.step[0] * cells, y + vertex.grid[1] / scale + way.step[1] * cells);
        let angle = way.radians * cells * scale;
        (height - vertex.height) / (self.radius * angle) - 0.5 * angle
    }

    fn near_horizon(&self, vertex: &GridVertex, way: Way) -> f32 {
        let own = NEAR.iter().map(|&cells| self.tangent(0, vertex, way, cells)).fold(f32::MIN, f32::max);
        let coarser = 1..self.grids.len().min(usize::from(FINE_LEVELS) + 1);
        coarser
            .flat_map(|k| FAR.iter().map(move |&cells| (k, cells)))
            .fold(own, |most, (k, cells)| most.max(self.tangent(k, vertex, way, cells)))
    }

    fn far_horizon(&self, vertex: &GridVertex, way: Way) -> f32 {
        let coarser = usize::from(FINE_LEVELS) + 1..self.grids.len();
        let look = |(k, &cells): (usize, &f64)| self.tangent(k, vertex, way, cells);
        coarser.flat_map(|k| FAR.iter().map(move |cells| (k, cells))).map(look).fold(-1.0, f32::max)
    }

    /// Share of an even sky's light: the mean over azimuths of the squared cosine of the horizon's elevation.
    fn sky(&self, vertex: &GridVertex) -> f32 {
        let east = vertex.axes[0].normalize();
        let north = vertex.up.cross(east);
        let open = |k: usize| {
            let angle = k as f64 * std::f64::consts::TAU / SKY_AZIMUTHS as f64;
            let way = vertex.towards(east * angle.cos() + north * angle.sin());
            let near = SKY_NEAR.iter().map(|&cells| self.tangent(0, vertex, way, cells)).fold(0.0, f32::max);
            let far = 1..self.grids.len().min(usize::from(SKY_LEVELS));
            let tangent =
                far.fold(near, |most, k| most.max(self.tangent(k, vertex, way, 5.0)).max(self.tangent(k, vertex, way, 7.0)));
            1.0 / (1.0 + tangent * tangent)
        };
        (0..SKY_AZIMUTHS).map(open).sum::<f32>() / SKY_AZIMUTHS as f32
    }
}
