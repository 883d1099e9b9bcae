//! The local frame of a landmark on the sphere with a heading. In: latitude, longitude, heading. Out: coordinates of a chunk's points about it.

use super::points::{axes, Lane, Points, LANES};
use terrane_heightfield::angles::sin_cos;

/// A point of the sphere and the directions there.
pub(crate) struct LocalFrame {
    /// Metres from the planet's centre.
    centre: [f64; 3],
    /// Unit vectors: up, along the heading's right, along the heading.
    frame: [[f64; 3]; 3],
}

impl LocalFrame {
    /// `heading_deg` is clockwise from north.
    pub(crate) fn new(latitude_deg: f64, longitude_deg: f64, heading_deg: f64, planet_m: f64) -> Self {
        let ((sa, ca), (so, co), (sh, ch)) = (sin_cos(latitude_deg), sin_cos(longitude_deg), sin_cos(heading_deg));
        let up = [ca * co, ca * so, sa];
        let (east, north) = ([-so, co, 0.0], [-sa * co, -sa * so, ca]);
        let along = axes(|k| north[k] * ch + east[k] * sh);
        let right = axes(|k| east[k] * ch - north[k] * sh);
        Self { centre: axes(|k| up[k] * planet_m), frame: [up, right, along] }
    }

    /// Squared distances straight through the planet, in square metres.
    #[inline(always)]
    pub(crate) fn distances2(&self, p: &Points) -> Lane {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            let [x, y, z] = axes(|k| p.position[k][i] - self.centre[k]);
            out[i] = (x * x + y * y + z * z) as f32;
        }
        out
    }

    /// Metres from the planet's centre towards the site, to the heading's right and along it.
    #[inline(always)]
    pub(crate) fn lanes(&self, p: &Points) -> [Lane; 3] {
        let mut out = [[0.0; LANES]; 3];
        for (out, axis) in out.iter_mut().zip(self.frame) {
            for i in 0..LANES {
                out[i] = (p.position[0][i] * axis[0] + p.position[1][i] * axis[1] + p.position[2][i] * axis[2]) as f32;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_point_where_they_say() {
        let at = |point: [f64; 3], heading: f64| {
            let frame = LocalFrame::new(0.0, 90.0, heading, 1000.0);
            let p = Points::at(point.map(|x| [x; LANES]));
            (frame.distances2(&p)[0], frame.lanes(&p).map(|lane| lane[0].round()))
        };
        assert_eq!(at([0.0, 1000.0, 0.0], 0.0), (0.0, [1000.0, 0.0, 0.0]));
        // East of longitude 90 is -x, north is z.
        assert_eq!(at([-10.0, 1000.0, 0.0], 0.0).1, [1000.0, 10.0, 0.0]);
        assert_eq!(at([-10.0, 1000.0, 0.0], 90.0).1, [1000.0, 0.0, 10.0]);
        assert_eq!(at([0.0, 1000.0, 20.0], 90.0).1, [1000.0, -20.0, 0.0]);
    }
}
