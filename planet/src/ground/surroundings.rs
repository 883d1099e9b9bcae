//! Heights around a patch, beyond its own samples: what horizons are looked up in.
//!
//! In: terrain and a patch, or heights that were kept. Out: [`Surroundings`], rounded to a small share of a cell, so that it makes no difference
//! whether they were sampled or kept in a file.

use super::kept::{sample_square, SampledHeights};
use super::{Ground, WarpedGrid};
use crate::globe::patch::PatchId;
use crate::globe::patch_cache::PatchCache;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Samples known beyond each side of a patch, in cells: no look-up goes farther in its own density.
pub const MARGIN: i32 = 10;

/// Steps of height along a cell, at least: horizon angles are right to a quarter of a degree one cell away, and to less farther off.
const STEPS_A_CELL: f64 = 256.0;

/// Patches of which [`KnownSurroundings`] are kept, of some 30 kB each at 64 cells a side.
const MOST_KEPT: usize = 1024;

/// Samples along a side of the surroundings of a patch of `cells` cells.
pub const fn surroundings_side(cells: u32) -> usize {
    cells as usize + 2 * MARGIN as usize + 1
}

/// Metres a step of height: the largest power of two of which a cell has enough.
fn step_m(ground: &Ground, level: u8) -> f64 {
    let finest = ground.lattice.sample_spacing(ground.cells, level) * ground.lattice.unit / STEPS_A_CELL;
    // Without its mantissa a number is the power of two below.
    f64::from_bits(finest.to_bits() >> 52 << 52)
}

fn steps(cells: u32) -> RangeInclusive<i32> {
    -MARGIN..=cells as i32 + MARGIN
}

/// The heights of a patch and its surroundings in steps, row by row.
pub fn sample_surroundings(ground: &Ground, id: PatchId) -> Vec<i32> {
    let warped = WarpedGrid::new(id, steps(ground.cells), ground.cells);
    let side = surroundings_side(ground.cells);
    let known: Vec<SampledHeights> =
        ground.kept.map_or_else(Vec::new, |kept| id.parent().into_iter().chain([id]).filter_map(|id| kept.get(id)).collect());
    let direction = |k: usize| warped.direction(k % side, k / side);
    let metres = sample_square(ground, &known, id, (steps(ground.cells), ground.cells), direction);
    let step = step_m(ground, id.level);
    metres.into_iter().map(|height| (height / step).round() as i32).collect()
}

/// The ground of a patch and around it.
pub struct Surroundings {
    /// Directions of the samples.
    pub(super) warped: WarpedGrid,
    /// Samples a side.
    pub(super) side: usize,
    /// Heights in metres, row by row.
    pub(super) metres: Vec<f32>,
}

impl Surroundings {
    /// From heights as [`sample_surroundings`] gives them, of [`surroundings_side`] squared samples.
    pub fn new(ground: &Ground, id: PatchId, heights: &[i32]) -> Surroundings {
        let step = step_m(ground, id.level);
        let metres = heights.iter().map(|&height| (f64::from(height) * step) as f32).collect();
        let warped = WarpedGrid::new(id, steps(ground.cells), ground.cells);
        Surroundings { warped, side: surroundings_side(ground.cells), metres }
    }

    /// From the terrain.
    pub fn sample(ground: &Ground, id: PatchId) -> Surroundings {
        Surroundings::new(ground, id, &sample_surroundings(ground, id))
    }
}

/// Surroundings of the patches asked for last: siblings share those of all their ancestors.
pub struct KnownSurroundings {
    kept: Mutex<PatchCache<Arc<Surroundings>>>,
}

impl Default for KnownSurroundings {
    fn default() -> KnownSurroundings {
        KnownSurroundings { kept: Mutex::new(PatchCache::new(MOST_KEPT)) }
    }
}

impl KnownSurroundings {
    /// Those of a patch, `found` if they are not known.
    pub fn get(&self, id: PatchId, found: impl FnOnce() -> Surroundings) -> Arc<Surroundings> {
        if let Some(known) = self.lock().get(id) {
            return known;
        }
        // Two threads may look for the same: they find the same.
        let found = Arc::new(found());
        self.lock().insert(id, found.clone());
        found
    }

    /// Those of the patches that a condition names, for a ground that is the same around these.
    pub fn of_those(&self, condition: impl Fn(PatchId) -> bool) -> KnownSurroundings {
        KnownSurroundings { kept: Mutex::new(self.lock().of_those(condition)) }
    }

    /// What [`HorizonMap`](super::horizon::HorizonMap) asks for, from the terrain.
    pub fn sampled<'a>(&'a self, ground: &'a Ground) -> impl FnMut(PatchId) -> Arc<Surroundings> + 'a {
        |id| self.get(id, || Surroundings::sample(ground, id))
    }

    fn lock(&self) -> MutexGuard<'_, PatchCache<Arc<Surroundings>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
