//! What every simplifier here does: gather a vertex's star, rank its collapses, measure one, perform it. The order, and what is
//! allowed, is up to the caller.
//!
//! A removed sample stays in the list of the triangle below it, so that each new fan is measured at all samples it covers and
//! errors never add up unseen.

use super::fan::Fan;
use super::mesh::{Mesh, NONE};
use super::samples::{area, Samples};
use super::star::{opposite, Candidate, Star, LEAST_AREA};
use super::sweep::Sweep;

/// A mesh between two collapses, with the samples it approximates.
pub struct Decimator {
    /// Current connectivity.
    pub mesh: Mesh,
    /// All samples, living or removed.
    pub samples: Samples,
    /// The star gathered last.
    pub star: Star,
    fan: Fan,
    sweep: Sweep,
    /// Every sample below the gathered star with its triangle in `fan`.
    triangles: Vec<(u32, u32)>,
}

impl Decimator {
    /// The full grid of `columns` × `rows` samples.
    pub fn new(samples: Samples, columns: usize, rows: usize) -> Decimator {
        Decimator {
            mesh: Mesh::grid(columns, rows),
            samples,
            star: Star::default(),
            fan: Fan::default(),
            sweep: Sweep::default(),
            triangles: Vec::new(),
        }
    }

    /// Whether a vertex still exists.
    pub fn is_alive(&self, v: u32) -> bool {
        self.mesh.outgoing(v) != NONE
    }

    /// Gathers the star of a living vertex, for the calls below.
    pub fn gather(&mut self, v: u32) {
        self.star.gather(&self.mesh, &self.samples, v);
    }

    /// The allowed collapse of the gathered vertex that has the least error, to single precision.
    pub fn rank(&mut self, allowed: impl Fn(u32) -> bool) -> Option<Candidate> {
        self.star.rank(allowed, |_, _| 0.0, 0.0)
    }

    /// The same with the errors between samples counted too: where new edges cross those of the full grid. The difference of two
    /// piecewise linear surfaces is largest at a corner of one of them, which is a sample, or there. `error` is that of a
    /// sample beside a crossing, by its number, between the grid's depth and the edge's; its unit is `unit` in depth.
    pub fn rank_between(
        &mut self,
        allowed: impl Fn(u32) -> bool,
        error: impl Fn(u32, f64, f64) -> f64,
        unit: f64,
    ) -> Option<Candidate> {
        let samples = &self.samples;
        self.star.rank(allowed, |ring, p| samples.error_between(ring, p, &error), unit)
    }

    /// Edges of the gathered ring that make a triangle with its vertex `p`, counter-clockwise.
    fn edges_across(&self, p: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let ring = &self.star.ring;
        let pairs = if self.star.closed { ring.len() } else { ring.len() - 1 };
        (0..pairs).map(|k| [ring[k], ring[if k + 1 < ring.len() { k + 1 } else { 0 }]]).filter(move |edge| !edge.contains(&p))
    }

    /// Whether the gathered vertex can collapse into `p` of its ring: no triangle turns over or vanishes.
    pub fn is_open(&self, p: u32) -> bool {
        let apex = self.samples.at(p);
        self.edges_across(p).all(|[a, b]| area(&apex, &self.samples.at(a), &self.samples.at(b)) > LEAST_AREA)
    }

    /// The largest error of the gathered vertex's collapse into `p`, which must see its whole ring. `error` is that of a
    /// sample, by its number, between two depths: its own and that of the new triangles.
    pub fn measure(&mut self, p: u32, error: impl Fn(u32, f64, f64) -> f64) -> f64 {
        let mut fan = std::mem::take(&mut self.fan);
        fan.start(&self.samples.at(p));
        self.edges_across(p).for_each(|[a, b]| fan.push(&self.samples.at(a), &self.samples.at(b)));
        self.fan = fan;
        self.triangles.clear();
        let mut worst = 0.0f64;
        for chunk in self.star.below() {
            let (triangles, depths) = self.fan.locate(chunk.x, chunk.y);
            for (lane, &number) in chunk.numbers.iter().enumerate().filter(|&(_, &number)| number != NONE) {
                worst = worst.max(error(number, chunk.q.0[lane], depths.0[lane]));
                self.triangles.push((number, triangles[lane]));
            }
        }
        worst
    }

    /// The largest error at samples while `v`, which is gathered, slides to `p`, if that is more than at both ends.
    pub fn measure_slide(&mut self, v: u32, p: u32, error: impl Fn(u32, f64, f64) -> f64) -> f64 {
        let [start, end] = [v, p].map(|k| self.samples.at(k));
        let mut sweep = std::mem::take(&mut self.sweep);
        sweep.start(&end);
        opposite(&self.star.ring, p).for_each(|r| sweep.push(&end, &start, &self.samples.at(r)));
        let mut worst = 0.0f64;
        for chunk in self.star.below() {
            let [low, high] = sweep.range(chunk.x, chunk.y, chunk.q);
            for (lane, &number) in chunk.numbers.iter().enumerate().filter(|&(_, &number)| number != NONE) {
                let own = chunk.q.0[lane];
                worst = worst.max(error(number, own, low.0[lane])).max(error(number, own, high.0[lane]));
            }
        }
        self.sweep = sweep;
        worst
    }

    /// Performs the collapse of the gathered vertex that was measured last. The ring stays readable.
    pub fn collapse(&mut self, v: u32, p: u32) {
        self.mesh.collapse(v, p, &mut self.star.edges);
        // The star's edges come in ring order, and so do the fan's triangles: those that survived, in the same order.
        for &e in &self.star.edges {
            self.mesh.set_first_sample(e, NONE);
        }
        for &(s, triangle) in &self.triangles {
            let e = self.star.edges[triangle as usize];
            self.samples.set_next(s, self.mesh.first_sample(e));
            self.mesh.set_first_sample(e, s);
        }
    }
}
