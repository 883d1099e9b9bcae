//! Flips edges of hot faces where that lowers the cost of the two faces beside. In: a triangulation and the peaks of its faces.
//! Out: both, changed.

use super::mesh::{doubled_area, Triangulation};
use super::residual::{cost, peak};
use super::{largest, HOT};
use crate::Heightfield;

/// A flip lowers the cost to less than this share, so that flips end.
const GAIN: f64 = 0.999;

/// Flips until no edge of a hot face gains, or for four visits a hot face.
pub(super) fn flip_edges(mesh: &mut Triangulation, field: &Heightfield, peaks: &mut [f64]) {
    let top = largest(peaks);
    if top == 0.0 {
        return;
    }
    let mut flips = Flips { costs: vec![f64::NAN; peaks.len()], mesh, field, peaks, top };
    let mut waiting: Vec<u32> = (0..flips.peaks.len() as u32).filter(|&t| flips.is_hot(t)).rev().collect();
    let mut visits = 4 * waiting.len();
    while let Some(face) = waiting.pop() {
        if visits == 0 {
            break;
        }
        visits -= 1;
        flips.visit(face, &mut waiting);
    }
}

struct Flips<'a> {
    mesh: &'a mut Triangulation,
    field: &'a Heightfield,
    peaks: &'a mut [f64],
    /// Costs of faces; NaN where not known.
    costs: Vec<f64>,
    top: f64,
}

impl Flips<'_> {
    fn is_hot(&self, face: u32) -> bool {
        self.peaks[face as usize] > HOT * self.top
    }

    fn cost(&mut self, face: u32) -> f64 {
        if self.costs[face as usize].is_nan() {
            self.costs[face as usize] = cost(self.mesh.triangle(face), self.field, self.top);
        }
        self.costs[face as usize]
    }

    fn visit(&mut self, face: u32, waiting: &mut Vec<u32>) {
        for edge in 3 * face..3 * face + 3 {
            let Some(twin) = self.mesh.twin(edge) else { continue };
            if self.try_flip(edge, twin) {
                for changed in [face, twin / 3] {
                    self.peaks[changed as usize] = peak(self.mesh.triangle(changed), self.field);
                    if self.is_hot(changed) {
                        waiting.push(changed);
                    }
                }
                return;
            }
        }
    }

    fn try_flip(&mut self, edge: u32, twin: u32) -> bool {
        let mesh = &self.mesh;
        let (a, b, c, d) = (mesh.origin(edge), mesh.origin(twin), mesh.apex(edge), mesh.apex(twin));
        let turned = [[c, a, d], [d, b, c]].map(|corners| mesh.positions_of(corners));
        if turned.iter().any(|&triangle| doubled_area(triangle) <= 0.0) {
            return false;
        }
        let now = self.cost(edge / 3) + self.cost(twin / 3);
        let first = cost(turned[0], self.field, self.top);
        if first >= GAIN * now {
            return false;
        }
        let second = cost(turned[1], self.field, self.top);
        let gains = first + second < GAIN * now;
        if gains {
            self.mesh.flip(edge, twin);
            (self.costs[edge as usize / 3], self.costs[twin as usize / 3]) = (first, second);
        }
        gains
    }
}
