//! Heights of the patches sampled last. A patch has every fourth sample in common with its parent, and most of its surroundings: what
//! the terrain was asked for once is taken from here, with the same bits. No result depends on what is kept.

use super::{strips, Ground, HeightGrid, GUTTER};
use crate::globe::patch::PatchId;
use crate::globe::patch_cache::PatchCache;
use crate::globe::sphere::CubePoint;
use glam::DVec3;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes kept at most.
const MOST_BYTES: usize = 24 << 20;

/// The heights of a patch's samples, in metres: every half cell, and the gutters.
#[derive(Clone)]
pub struct SampledHeights {
    /// The patch.
    pub id: PatchId,
    /// Samples a side.
    pub side: usize,
    /// Heights row by row.
    pub metres: Arc<Vec<f64>>,
}

impl SampledHeights {
    /// Half cells along the patch's side.
    fn parts(&self) -> u32 {
        (self.side as i32 - 1 - 2 * GUTTER) as u32
    }

    /// Column (axis 0) or row (axis 1) of the samples at a coordinate along that axis of the face, in cube units.
    fn line(&self, axis: usize, coordinate: i32) -> Option<usize> {
        let (u, v) = self.id.face.grid_axes();
        let first = self.id.point(0, 0, self.parts())[[u, v][axis]];
        let step = (1i64 << (31 - self.id.level)) / i64::from(self.parts());
        let offset = i64::from(coordinate) - i64::from(first) + i64::from(GUTTER) * step;
        let is_sample = (0..self.side as i64 * step).contains(&offset) && offset % step == 0;
        is_sample.then_some((offset / step) as usize)
    }

    /// Index of the sample at a cube point, if there is one. Points on the other face beside a cube edge are none of this patch's.
    pub fn find(&self, point: CubePoint) -> Option<usize> {
        let (u, v) = self.id.face.grid_axes();
        let normal = self.id.face.normal_axis();
        if point[normal] != self.id.point(0, 0, 1)[normal] {
            return None;
        }
        Some(self.line(1, point[v])? * self.side + self.line(0, point[u])?)
    }

    /// Copies what is known of a square of samples of `id`, or of a patch within, at steps of which `parts` are a side.
    fn fill(&self, id: PatchId, steps: RangeInclusive<i32>, parts: u32, metres: &mut [f64]) {
        let (u, v) = id.face.grid_axes();
        let columns: Vec<Option<usize>> = steps.clone().map(|a| self.line(0, id.point(a, 0, parts)[u])).collect();
        let rows = steps.map(|b| self.line(1, id.point(0, b, parts)[v]));
        for (row, metres) in rows.zip(metres.chunks_exact_mut(columns.len())) {
            let Some(row) = row else { continue };
            let own = &self.metres[row * self.side..(row + 1) * self.side];
            for (metres, column) in metres.iter_mut().zip(&columns) {
                *metres = column.map_or(*metres, |column| own[column]);
            }
        }
    }
}

/// Heights of the patches sampled last.
pub struct KeptHeights {
    kept: Mutex<PatchCache<SampledHeights>>,
}

impl KeptHeights {
    /// Room for patches of so many cells a side: some 24 MB.
    pub fn new(cells: u32) -> KeptHeights {
        let side = (2 * cells as i32 + 2 * GUTTER + 1) as usize;
        KeptHeights { kept: Mutex::new(PatchCache::new(MOST_BYTES / (side * side * size_of::<f64>()))) }
    }

    /// Keeps a patch's samples.
    pub fn keep(&self, grid: &HeightGrid) {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).insert(grid.id, grid.sampled.clone());
    }

    /// What is kept of a patch.
    pub fn get(&self, id: PatchId) -> Option<SampledHeights> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).get(id)
    }
}

/// Heights in metres of a square of samples, row by row: those of a patch at steps of which `parts` are a side. What `known` has of them
/// is taken from there.
pub(super) fn sample_square<'a>(
    ground: &Ground,
    known: impl IntoIterator<Item = &'a SampledHeights>,
    id: PatchId,
    (steps, parts): (RangeInclusive<i32>, u32),
    direction: impl Fn(usize) -> DVec3,
) -> Vec<f64> {
    let side = steps.clone().count();
    let mut metres = vec![f64::NAN; side * side];
    known.into_iter().for_each(|heights| heights.fill(id, steps.clone(), parts, &mut metres));
    // Near in memory is near on the ground, which terrain is fastest for.
    let order: Vec<usize> = strips(side).into_iter().filter(|&k| metres[k].is_nan()).collect();
    let directions: Vec<DVec3> = order.iter().map(|&k| direction(k)).collect();
    for (&k, height) in order.iter().zip(ground.metres(&directions)) {
        metres[k] = height;
    }
    metres
}
