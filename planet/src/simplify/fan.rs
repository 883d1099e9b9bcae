//! Fans: triangles around one apex that would replace a star, measured in double precision.

use super::lanes::{Doubles, LANES};
use super::samples::Sample;
use multiversion::multiversion;

/// How far, in doubled cells, a sample may lie outside a wedge and still belong to it.
const SLACK: f64 = 1e-9;

/// One triangle (apex, a, b) of a fan, relative to the apex.
struct Wedge {
    a: [f64; 2],
    b: [f64; 2],
    slope: [f64; 2],
}

impl Wedge {
    /// How far inside of both sides from the apex a place is: doubled areas, the smaller one.
    #[inline(always)]
    fn inside(&self, x: f64, y: f64) -> f64 {
        (self.a[0] * y - self.a[1] * x).min(x * self.b[1] - y * self.b[0])
    }
}

/// A fan of triangles that share their first corner; reused between evaluations to avoid allocation.
#[derive(Default)]
pub struct Fan {
    apex: [f64; 3],
    wedges: Vec<Wedge>,
}

impl Fan {
    /// Starts a new fan around `apex`.
    pub fn start(&mut self, apex: &Sample) {
        self.apex = [apex.x, apex.y, apex.q];
        self.wedges.clear();
    }

    /// Adds the triangle (apex, a, b), which must be counter-clockwise.
    pub fn push(&mut self, a: &Sample, b: &Sample) {
        let [x, y, q] = self.apex;
        let (ra, rb) = ([a.x - x, a.y - y], [b.x - x, b.y - y]);
        let area = ra[0] * rb[1] - ra[1] * rb[0];
        let (qa, qb) = (a.q - q, b.q - q);
        let slope = [(qa * rb[1] - qb * ra[1]) / area, (qb * ra[0] - qa * rb[0]) / area];
        self.wedges.push(Wedge { a: ra, b: rb, slope });
    }

    /// For eight places inside the fan's polygon the triangle (by order of [`Fan::push`]) that holds each, and the depth of the fan
    /// there. A place on the rim belongs to the nearest triangle.
    #[inline]
    pub(super) fn locate(&self, x: Doubles, y: Doubles) -> ([u32; LANES], Doubles) {
        locate(self.apex, &self.wedges, x, y)
    }

    /// Depth of the fan at a sample, or `None` where no triangle of the fan covers it.
    pub fn depth_if_covered(&self, sample: &Sample) -> Option<f64> {
        let (x, y) = (sample.x - self.apex[0], sample.y - self.apex[1]);
        let covers =
            |w: &Wedge| w.inside(x, y) >= -SLACK && (w.b[0] - w.a[0]) * (y - w.a[1]) - (w.b[1] - w.a[1]) * (x - w.a[0]) >= -SLACK;
        let wedge = self.wedges.iter().position(covers)?;
        Some(self.depth(wedge, x, y))
    }

    #[inline(always)]
    fn depth(&self, wedge: usize, x: f64, y: f64) -> f64 {
        let [sx, sy] = self.wedges[wedge].slope;
        self.apex[2] + sx * x + sy * y
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn locate(apex: [f64; 3], wedges: &[Wedge], x: Doubles, y: Doubles) -> ([u32; LANES], Doubles) {
    let (x, y) = (x - Doubles::splat(apex[0]), y - Doubles::splat(apex[1]));
    let mut inside = Doubles::splat(f64::NEG_INFINITY);
    let [mut found, mut sx, mut sy] = [Doubles::splat(0.0); 3];
    for (k, wedge) in wedges.iter().enumerate() {
        let from_a = Doubles::splat(wedge.a[0]) * y - Doubles::splat(wedge.a[1]) * x;
        let to_b = x * Doubles::splat(wedge.b[1]) - y * Doubles::splat(wedge.b[0]);
        let depth = from_a.min(to_b);
        let deeper = depth.more_than(inside);
        inside = deeper.select(depth, inside);
        found = deeper.select(Doubles::splat(k as f64), found);
        sx = deeper.select(Doubles::splat(wedge.slope[0]), sx);
        sy = deeper.select(Doubles::splat(wedge.slope[1]), sy);
    }
    (found.0.map(|k| k as u32), Doubles::splat(apex[2]) + sx * x + sy * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_met_everywhere_and_only_below_its_triangles() {
        let plane = |x: f64, y: f64| Sample { x, y, q: 1.0 + 0.25 * x - 0.125 * y };
        let mut fan = Fan::default();
        fan.start(&plane(0.0, 0.0));
        fan.push(&plane(2.0, 0.0), &plane(2.0, 2.0));
        fan.push(&plane(2.0, 2.0), &plane(0.0, 2.0));
        for (x, y, triangle) in [(1.5, 0.5, 0), (0.5, 1.5, 1), (2.0, 0.0, 0)] {
            let sample = plane(x, y);
            assert_eq!(fan.locate(Doubles::splat(x), Doubles::splat(y)), ([triangle; LANES], Doubles::splat(sample.q)));
            assert_eq!(fan.depth_if_covered(&sample), Some(sample.q));
        }
        assert_eq!(fan.depth_if_covered(&plane(3.0, 1.0)), None);
    }
}
