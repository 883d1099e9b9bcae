//! What a star looks like while its vertex slides to where it collapses to, or back.
//!
//! The vertex v moves on a straight line to p of its ring, and the other corners stand still. At a point in the star the surface
//! moves up or down as long as one triangle covers it, and turns round only when an edge from the vertex to some r of the ring passes
//! below. At that moment the point lies on the triangle (p, v, r). So the surface is between its two ends or, at worst, on one
//! of these triangles; between samples it is worst at their sides, which are edges of the meshes before and after.

use super::fan::Wedge;
use super::lanes::Doubles;
use super::samples::{area, Sample};
use multiversion::multiversion;

/// Doubled area, in cells, below which a triangle is taken for a line.
const NO_AREA: f64 = 1e-9;

/// The triangles (p, v, r) of a slide from v to p; reused between evaluations to avoid allocation.
#[derive(Default)]
pub struct Sweep {
    apex: [f64; 3],
    wedges: Vec<Wedge>,
}

impl Sweep {
    /// Starts a slide to `p`.
    pub fn start(&mut self, p: &Sample) {
        self.apex = [p.x, p.y, p.q];
        self.wedges.clear();
    }

    /// Adds the triangle of the slide from `v`, whose edge to `r` stays.
    pub fn push(&mut self, p: &Sample, v: &Sample, r: &Sample) {
        let doubled = area(p, v, r);
        if doubled > NO_AREA {
            self.wedges.push(Wedge::new(self.apex, v, r));
        } else if doubled < -NO_AREA {
            self.wedges.push(Wedge::new(self.apex, r, v));
        }
    }

    /// The lowest and the highest depth that an edge passes eight points of these depths with; the depths themselves where none
    /// does.
    pub fn range(&self, x: Doubles, y: Doubles, q: Doubles) -> [Doubles; 2] {
        range(self.apex, &self.wedges, x, y, q)
    }
}

#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn range(apex: [f64; 3], wedges: &[Wedge], x: Doubles, y: Doubles, q: Doubles) -> [Doubles; 2] {
    let (x, y) = (x - Doubles::splat(apex[0]), y - Doubles::splat(apex[1]));
    let (mut low, mut high) = (q, q);
    for wedge in wedges {
        let depth = Doubles::splat(apex[2]) + wedge.rise(x, y);
        let passes = wedge.inside(x, y).more_than(Doubles::splat(0.0));
        low = passes.select(low.min(depth), low);
        high = passes.select(depth.more_than(high).select(depth, high), high);
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decimate::fan::Fan;
    use crate::decimate::lanes::LANES;
    use proptest::prelude::*;

    /// Depth at a point of the fan from `apex` over a ring of corners.
    fn depth(apex: &Sample, ring: &[Sample], x: f64, y: f64) -> f64 {
        let mut fan = Fan::default();
        fan.start(apex);
        (0..ring.len()).for_each(|k| fan.push(&ring[k], &ring[(k + 1) % ring.len()]));
        fan.cover(Doubles::splat(x), Doubles::splat(y)).1 .0[0]
    }

    proptest! {
        /// A convex ring of eight, the vertex anywhere well inside: nowhere on its way does the surface leave the range.
        #[test]
        fn a_slide_stays_within_its_range(heights in prop::array::uniform9(-1.0f64..1.0), at in prop::array::uniform2(-0.4f64..0.4),
            point in prop::array::uniform2(-0.6f64..0.6)) {
            let corner = |k: usize| {
                let (y, x) = (k as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
                Sample { x, y, q: 10.0 + heights[k] }
            };
            let ring: Vec<Sample> = (0..8).map(corner).collect();
            let v = Sample { x: at[0], y: at[1], q: 10.0 + heights[8] };
            let [x, y] = point;
            let mut sweep = Sweep::default();
            sweep.start(&ring[0]);
            ring[2..7].iter().for_each(|r| sweep.push(&ring[0], &v, r));
            let slid = |t: f64| {
                let p = &ring[0];
                let apex = Sample { x: p.x + t * (v.x - p.x), y: p.y + t * (v.y - p.y), q: p.q + t * (v.q - p.q) };
                depth(&apex, &ring, x, y)
            };
            let ends = [slid(1e-9), slid(1.0)];
            let [low, high] = sweep.range(Doubles::splat(x), Doubles::splat(y), Doubles([ends[0]; LANES]));
            let (low, high) = (low.0[0].min(ends[1]), high.0[0].max(ends[1]));
            for k in 1..64 {
                let now = slid(f64::from(k) / 64.0);
                prop_assert!(low - 1e-6 <= now && now <= high + 1e-6, "{now} is not within {low} and {high}");
            }
        }
    }

    #[test]
    fn an_edge_that_passes_counts_and_one_beside_does_not() {
        let at = |x: f64, y: f64, q: f64| Sample { x, y, q };
        let (p, v) = (at(0.0, 0.0, 1.0), at(4.0, 0.0, 1.0));
        let mut sweep = Sweep::default();
        sweep.start(&p);
        sweep.push(&p, &v, &at(2.0, 4.0, 3.0));
        let range = |x: f64, y: f64| sweep.range(Doubles::splat(x), Doubles::splat(y), Doubles::splat(1.5)).map(|q| q.0[0]);
        assert_eq!(range(2.0, 2.0), [1.5, 2.0]);
        assert_eq!(range(2.0, -1.0), [1.5, 1.5]);
    }
}
