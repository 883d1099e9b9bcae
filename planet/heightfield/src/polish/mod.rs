//! Lowers the largest error of a triangulated heightfield at a given number of faces. In: a surface with its vertices on samples
//! and somewhat fewer faces than are wanted, and the field. Out: a surface with the wanted number.
//!
//! Collapses leave two things unused: that a vertex need not lie on the ground, and that it may come back elsewhere. So rounds of
//! four steps follow: [`remove`] vertices that are hardly needed, [`insert`] others at the worst samples, [`flip`] edges, and
//! [`fit`] the heights of vertices. Greedy insertion is due to Garland and Heckbert (1995), flips that follow the data to Dyn,
//! Levin and Rippa (1990); the fit lowers a p-norm with rising p, the usual smooth way to the largest residual.
//!
//! Everything is in a fixed order and sums are taken in it, so the result does not depend on the number of threads.

mod fit;
mod flip;
mod insert;
mod mesh;
mod remove;
mod residual;

use crate::{Heightfield, TriangleSurface};
use fit::{fit, Sweeps};
use flip::flip_edges;
use insert::insert_worst;
use mesh::Triangulation;
use rayon::prelude::*;
use remove::remove_calm;

/// Share of the wanted faces that a surface best starts with; the rest is inserted where it helps most.
pub(crate) const START_SHARE: f64 = 0.9;

/// Faces with a residual above this share of the largest are flipped, and their vertices fitted.
const HOT: f64 = 0.5;

/// Vertices are inserted where residuals are above this share of the largest.
const INSERT_ABOVE: f64 = 0.9;

/// Rounds that insert what is missing: all but the last at least a third of it.
const GROWTH_ROUNDS: usize = 6;

/// Vertices are removed where that leaves residuals below this share of the largest.
const CALM: f64 = 0.9;

/// Most faces that one round moves elsewhere, as a share of all.
const SWAPPED_SHARE: f64 = 0.06;

/// Most rounds that move vertices elsewhere.
const SWAP_ROUNDS: usize = 3;

/// As many rounds in a row without a better surface are the last.
const PATIENCE: usize = 2;

/// Sweeps at the start (p = 8), in every round (p = 16) and at the end (p = 32).
const FIRST_FIT: Sweeps = Sweeps { doublings: 1, count: 4 };
const ROUND_FIT: Sweeps = Sweeps { doublings: 2, count: 6 };
const LAST_FIT: Sweeps = Sweeps { doublings: 3, count: 20 };

/// Polishes a surface that triangulates the rectangle of `field` with vertices on samples, up to `faces` faces or one less. The
/// outline and its corners stay where they are in the plane. The largest error may end above that of another surface with as many
/// faces: compare.
pub(crate) fn polish(surface: TriangleSurface, field: &Heightfield, faces: usize) -> TriangleSurface {
    let mut polish = Polish::new(surface, field);
    polish.flip_and_fit(FIRST_FIT);
    polish.grow(faces);
    let mut best = polish.improve(faces);
    fit(&mut best.mesh, field, &mut best.peaks, LAST_FIT);
    best.mesh.surface()
}

/// A surface being polished.
#[derive(Clone)]
struct Polish<'a> {
    field: &'a Heightfield,
    mesh: Triangulation,
    /// Largest residual of each face; 0 for those that were removed.
    peaks: Vec<f64>,
}

impl Polish<'_> {
    fn new(surface: TriangleSurface, field: &Heightfield) -> Polish<'_> {
        let mesh = Triangulation::new(surface);
        let faces = (0..mesh.capacity() as u32).into_par_iter();
        let peaks = faces.map(|face| residual::peak(mesh.triangle(face), field)).collect();
        Polish { field, mesh, peaks }
    }

    fn top(&self) -> f64 {
        largest(&self.peaks)
    }

    fn flip_and_fit(&mut self, sweeps: Sweeps) {
        flip_edges(&mut self.mesh, self.field, &mut self.peaks);
        fit(&mut self.mesh, self.field, &mut self.peaks, sweeps);
    }

    /// Inserts vertices up to the wanted number of faces, a part at a time because each lowers the need for others.
    fn grow(&mut self, faces: usize) {
        for round in 1..=GROWTH_ROUNDS {
            let missing = faces.saturating_sub(self.mesh.count()) / 2;
            if missing == 0 {
                return;
            }
            let least = if round == GROWTH_ROUNDS { missing } else { missing.div_ceil(3) };
            insert_worst(&mut self.mesh, self.field, &mut self.peaks, least, faces);
            self.flip_and_fit(ROUND_FIT);
        }
    }

    /// Rounds of swaps as long as they help; returns the best surface seen.
    fn improve(mut self, faces: usize) -> Self {
        let mut best = self.clone();
        let mut fruitless = 0;
        for _ in 0..SWAP_ROUNDS {
            self.swap(faces);
            if self.top() < best.top() {
                best = self.clone();
                fruitless = 0;
            } else {
                fruitless += 1;
            }
            if fruitless == PATIENCE {
                break;
            }
        }
        best
    }

    /// Takes vertices from where they are hardly needed to where the error is largest.
    fn swap(&mut self, faces: usize) {
        let most = (SWAPPED_SHARE * faces as f64 / 2.0).ceil() as usize;
        let limit = CALM * self.top();
        remove_calm(&mut self.mesh, self.field, &mut self.peaks, limit, most);
        let missing = faces.saturating_sub(self.mesh.count()) / 2;
        insert_worst(&mut self.mesh, self.field, &mut self.peaks, missing, faces);
        self.flip_and_fit(ROUND_FIT);
    }
}

/// The largest of residuals.
fn largest(peaks: &[f64]) -> f64 {
    peaks.iter().copied().fold(0.0, f64::max)
}
