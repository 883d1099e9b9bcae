//! Positions of samples in degrees, and their distances in metres on a body: the Earth, the Moon, any ellipsoid.

use crate::angles::sin_cos;
use std::f64::consts::PI;

/// The shape of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half its longer axis, in metres.
    pub semi_major_m: f64,
    /// Its first eccentricity, squared; 0 for a sphere.
    pub eccentricity_squared: f64,
}

impl Ellipsoid {
    /// The Earth, as GPS and most elevation data take it.
    pub const WGS_84: Ellipsoid = Ellipsoid { semi_major_m: 6_378_137.0, eccentricity_squared: 6.694_379_990_141_316e-3 };

    /// Metres a radian of longitude and of latitude at a latitude in degrees.
    pub fn radian_m(&self, latitude: f64) -> [f64; 2] {
        let (sine, cosine) = sin_cos(latitude);
        let squared = 1.0 - self.eccentricity_squared * sine * sine;
        let across = self.semi_major_m / squared.sqrt();
        [across * cosine, across * (1.0 - self.eccentricity_squared) / squared]
    }

    /// Whether it is about as large as the Earth, where no height is beyond 12 km.
    pub(super) fn is_earth_sized(&self) -> bool {
        (6.2e6..6.5e6).contains(&self.semi_major_m)
    }
}

/// A grid of samples along parallels and meridians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeographicGrid {
    /// Longitude of the first column's samples, in degrees.
    pub west: f64,
    /// Latitude of the first row's samples, in degrees.
    pub north: f64,
    /// Degrees from a sample to the next one east of it, above 0.
    pub step_east: f64,
    /// Degrees from a sample to the next one south of it, above 0.
    pub step_south: f64,
}

impl GeographicGrid {
    /// Latitude of the last row's samples, in degrees.
    pub fn south(&self, rows: usize) -> f64 {
        self.north - self.step_south * (rows - 1) as f64
    }

    /// Longitude of the last column's samples, in degrees.
    pub fn east(&self, columns: usize) -> f64 {
        self.west + self.step_east * (columns - 1) as f64
    }

    /// Metres between samples from west to east and from north to south at the middle latitude, on a body.
    pub fn spacing_m(&self, rows: usize, body: &Ellipsoid) -> [f64; 2] {
        let [across, along] = body.radian_m(0.5 * (self.north + self.south(rows)));
        [across * self.step_east * (PI / 180.0), along * self.step_south * (PI / 180.0)]
    }

    /// Whether all of it lies on the globe and runs the right way.
    pub(super) fn is_sound(&self, columns: usize, rows: usize) -> bool {
        let steps = [self.step_east, self.step_south].iter().all(|s| (1e-9..=90.0).contains(s));
        // Half a step of room for files that count from the corners of pixels.
        let latitudes = self.north <= 90.0 + self.step_south && self.south(rows) >= -90.0 - self.step_south;
        let turn = self.step_east * columns as f64 <= 360.0 + 2.0 * self.step_east;
        steps && latitudes && turn && (-540.0..=540.0).contains(&self.west)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_have_their_published_lengths() {
        let spacing =
            |north: f64| GeographicGrid { west: 0.0, north, step_east: 1.0, step_south: 1.0 }.spacing_m(2, &Ellipsoid::WGS_84);
        // Lengths of a degree on WGS 84, from published tables.
        let [east, south] = spacing(0.5);
        assert!((east - 111_319.5).abs() < 0.1 && (south - 110_574.3).abs() < 0.1, "{east} {south}");
        let [east, south] = spacing(60.5);
        assert!((east - 55_800.0).abs() < 1.0 && (south - 111_412.3).abs() < 1.0, "{east} {south}");
    }
}
