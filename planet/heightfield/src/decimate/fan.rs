//! Fans: triangles around one apex that would replace a star, measured in double precision.

use super::lanes::{Doubles, LANES};
use super::samples::Sample;
use multiversion::multiversion;

/// How far, in doubled cells, a point may lie outside a triangle and still belong to it.
pub const SLACK: f64 = 1e-9;

/// One triangle (apex, a, b) of a fan, relative to the apex.
pub struct Wedge {
    a: [f64; 2],
    b: [f64; 2],
    slope: [f64; 2],
}

impl Wedge {
    /// The triangle (apex, a, b), which must be counter-clockwise; the apex is given as position and depth.
    pub fn new([x, y, q]: [f64; 3], a: &Sample, b: &Sample) -> Wedge {
        let (ra, rb) = ([a.x - x, a.y - y], [b.x - x, b.y - y]);
        let area = ra[0] * rb[1] - ra[1] * rb[0];
        let (qa, qb) = (a.q - q, b.q - q);
        let slope = [(qa * rb[1] - qb * ra[1]) / area, (qb * ra[0] - qa * rb[0]) / area];
        Wedge { a: ra, b: rb, slope }
    }

    /// How much deeper than the apex the triangle's plane is at points.
    #[inline(always)]
    pub fn rise(&self, x: Doubles, y: Doubles) -> Doubles {
        Doubles::splat(self.slope[0]) * x + Doubles::splat(self.slope[1]) * y
    }

    /// How far inside of both sides from the apex points are: doubled areas, the smaller one.
    #[inline(always)]
    fn inside_sides(&self, x: Doubles, y: Doubles) -> Doubles {
        let from_a = Doubles::splat(self.a[0]) * y - Doubles::splat(self.a[1]) * x;
        let to_b = x * Doubles::splat(self.b[1]) - y * Doubles::splat(self.b[0]);
        from_a.min(to_b)
    }

    /// How far inside of all three sides.
    #[inline(always)]
    pub fn inside(&self, x: Doubles, y: Doubles) -> Doubles {
        let (bx, by) = (self.b[0] - self.a[0], self.b[1] - self.a[1]);
        let rim = Doubles::splat(bx) * (y - Doubles::splat(self.a[1])) - Doubles::splat(by) * (x - Doubles::splat(self.a[0]));
        self.inside_sides(x, y).min(rim)
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
        self.wedges.push(Wedge::new(self.apex, a, b));
    }

    /// For eight points inside the fan's polygon the triangle (by order of [`Fan::push`]) that holds each, and the depth of the
    /// fan there. A point on the rim belongs to the nearest triangle.
    #[inline]
    pub fn locate(&self, x: Doubles, y: Doubles) -> ([u32; LANES], Doubles) {
        locate(self.apex, &self.wedges, x, y)
    }

    /// For eight points how far inside the fan each is (doubled area, negative outside), and the depth of the fan there.
    #[inline]
    pub fn cover(&self, x: Doubles, y: Doubles) -> (Doubles, Doubles) {
        cover(self.apex, &self.wedges, x, y)
    }
}

#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn locate(apex: [f64; 3], wedges: &[Wedge], x: Doubles, y: Doubles) -> ([u32; LANES], Doubles) {
    let [found, _, depth] = deepest(apex, wedges, x, y, Wedge::inside_sides);
    (found.0.map(|k| k as u32), depth)
}

#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn cover(apex: [f64; 3], wedges: &[Wedge], x: Doubles, y: Doubles) -> (Doubles, Doubles) {
    let [_, inside, depth] = deepest(apex, wedges, x, y, Wedge::inside);
    (inside, depth)
}

/// The triangle that each point is furthest inside of, by a measure relative to the apex: its number, how far, and the fan's
/// depth.
#[inline(always)]
fn deepest(
    apex: [f64; 3],
    wedges: &[Wedge],
    x: Doubles,
    y: Doubles,
    measure: impl Fn(&Wedge, Doubles, Doubles) -> Doubles,
) -> [Doubles; 3] {
    let (x, y) = (x - Doubles::splat(apex[0]), y - Doubles::splat(apex[1]));
    let mut inside = Doubles::splat(f64::NEG_INFINITY);
    let [mut found, mut sx, mut sy] = [Doubles::splat(0.0); 3];
    for (k, wedge) in wedges.iter().enumerate() {
        let measured = measure(wedge, x, y);
        let deeper = measured.more_than(inside);
        inside = deeper.select(measured, inside);
        found = deeper.select(Doubles::splat(k as f64), found);
        sx = deeper.select(Doubles::splat(wedge.slope[0]), sx);
        sy = deeper.select(Doubles::splat(wedge.slope[1]), sy);
    }
    [found, inside, Doubles::splat(apex[2]) + sx * x + sy * y]
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
            let (inside, depth) = fan.cover(Doubles::splat(x), Doubles::splat(y));
            assert!(inside.0[7] >= 0.0 && depth == Doubles::splat(sample.q));
        }
        assert!(fan.cover(Doubles::splat(3.0), Doubles::splat(1.0)).0 .0[0] < -SLACK);
    }
}
