//! The radial error of a fan: triangles around one apex that would replace a star.

use super::surface::{Sample, Surface};

/// How far, in doubled cells, a sample may lie outside a wedge and still belong to it.
const SLACK: f64 = 1e-9;

/// One triangle (apex, a, b) of a fan, relative to the apex.
struct Wedge {
    a: [f64; 2],
    b: [f64; 2],
    slope: [f64; 2],
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

    /// Adds the triangle (apex, a, b), which must be counter-clockwise, and returns its doubled area.
    pub fn push(&mut self, a: &Sample, b: &Sample) -> f64 {
        let [x, y, q] = self.apex;
        let (ra, rb) = ([a.x - x, a.y - y], [b.x - x, b.y - y]);
        let area = ra[0] * rb[1] - ra[1] * rb[0];
        let (qa, qb) = (a.q - q, b.q - q);
        let slope = [(qa * rb[1] - qb * ra[1]) / area, (qb * ra[0] - qa * rb[0]) / area];
        self.wedges.push(Wedge { a: ra, b: rb, slope });
        area
    }

    /// Number of the triangle (in order of [`Fan::push`]) that holds a sample inside the fan's polygon; a sample on the rim goes
    /// to the nearest one.
    #[inline]
    pub fn locate(&self, sample: &Sample) -> usize {
        let (x, y) = (sample.x - self.apex[0], sample.y - self.apex[1]);
        let mut best = f64::NEG_INFINITY;
        let mut found = 0;
        for (k, wedge) in self.wedges.iter().enumerate() {
            let from_a = wedge.a[0] * y - wedge.a[1] * x;
            let to_b = x * wedge.b[1] - y * wedge.b[0];
            let inside = from_a.min(to_b);
            if inside > best {
                best = inside;
                found = k;
                if inside >= 0.0 {
                    break;
                }
            }
        }
        found
    }

    /// Radial error at a sample inside the fan's polygon.
    #[inline]
    pub fn error_inside(&self, sample: &Sample) -> f64 {
        let [sx, sy] = self.wedges[self.locate(sample)].slope;
        sample.radial_error(self.apex[2] + sx * (sample.x - self.apex[0]) + sy * (sample.y - self.apex[1]))
    }

    /// Radial error at a sample, or `None` where no triangle of the fan covers it.
    pub fn error_if_covered(&self, sample: &Sample) -> Option<f64> {
        let (x, y) = (sample.x - self.apex[0], sample.y - self.apex[1]);
        let covers = |w: &&Wedge| {
            w.a[0] * y - w.a[1] * x >= -SLACK
                && x * w.b[1] - y * w.b[0] >= -SLACK
                && (w.b[0] - w.a[0]) * (y - w.a[1]) - (w.b[1] - w.a[1]) * (x - w.a[0]) >= -SLACK
        };
        let wedge = self.wedges.iter().find(covers)?;
        Some(sample.radial_error(self.apex[2] + wedge.slope[0] * x + wedge.slope[1] * y))
    }

    /// Largest error over samples inside the polygon, or `None` once it reaches `limit`.
    pub fn largest_error(&self, surface: &Surface, samples: &[u32], limit: f64) -> Option<f64> {
        let mut worst = 0.0f64;
        for &s in samples {
            worst = worst.max(self.error_inside(&surface.samples[s as usize]));
            if worst >= limit {
                return None;
            }
        }
        Some(worst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, q: f64) -> Sample {
        Sample { x, y, q, gain: 1.0 }
    }

    #[test]
    fn a_plane_has_no_error_and_a_bump_has_its_own() {
        let plane = |x: f64, y: f64| at(x, y, 1.0 + 0.25 * x - 0.125 * y);
        let mut fan = Fan::default();
        fan.start(&plane(0.0, 0.0));
        assert_eq!(fan.push(&plane(2.0, 0.0), &plane(2.0, 2.0)), 4.0);
        fan.push(&plane(2.0, 2.0), &plane(0.0, 2.0));
        assert_eq!(fan.error_inside(&plane(0.5, 1.5)), 0.0);
        let mut bump = plane(1.0, 0.5);
        bump.q += 0.5;
        assert!((fan.error_inside(&bump) - 0.5 / 1.1875).abs() < 1e-12);
        assert!(fan.error_if_covered(&plane(3.0, 1.0)).is_none());
    }
}
