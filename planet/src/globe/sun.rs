//! Where the sun stands at a time: a low-precision solar position (Meeus 1991, chapter 25; within 0.02 degrees for centuries about
//! 2000). In: seconds since 1970 and the planet's axial tilt. Out: the planet-fixed direction towards the sun.
//!
//! Days and years are the Earth's, whatever the planet; longitude 0 is where the sun is highest about 12:00 UTC.

use super::sphere::direction_at;
use glam::DVec3;

/// The Earth's axial tilt in degrees.
pub const EARTH_TILT: f64 = 23.4393;

/// Seconds from 1970-01-01T00:00Z to 2000-01-01T12:00Z.
const J2000: f64 = 946_728_000.0;

/// Latitude and longitude in degrees of the site that has the sun overhead, `seconds` after 1970-01-01T00:00Z.
pub fn subsolar_point(seconds: f64, tilt_deg: f64) -> [f64; 2] {
    let days = (seconds - J2000) / 86_400.0;
    let t = days / 36_525.0;
    let mean_longitude = 280.46646 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = (357.52911 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
    let centre = (1.914602 - 0.004817 * t) * anomaly.sin() + 0.019993 * (2.0 * anomaly).sin() + 0.000289 * (3.0 * anomaly).sin();
    let node = (125.04 - 1934.136 * t).to_radians();
    let longitude = (mean_longitude + centre - 0.00569 - 0.00478 * node.sin()).to_radians();
    let tilt = tilt_deg.to_radians();
    let declination = (tilt.sin() * longitude.sin()).asin();
    let right_ascension = (tilt.cos() * longitude.sin()).atan2(longitude.cos());
    let sidereal = (280.460_618 + 360.985_647_366 * days).to_radians();
    let east = (right_ascension - sidereal).to_degrees();
    [declination.to_degrees(), (east + 180.0).rem_euclid(360.0) - 180.0]
}

/// Unit vector towards the sun, planet-fixed, `seconds` after 1970-01-01T00:00Z.
pub fn direction(seconds: f64, tilt_deg: f64) -> DVec3 {
    let [latitude, longitude] = subsolar_point(seconds, tilt_deg);
    direction_at(latitude, longitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds at days since 1970 and hours.
    fn at(days: f64, hours: f64) -> f64 {
        86_400.0 * days + 3600.0 * hours
    }

    #[track_caller]
    fn assert_near(found: [f64; 2], expected: [f64; 2]) {
        let apart = [found[0] - expected[0], (found[1] - expected[1] + 180.0).rem_euclid(360.0) - 180.0];
        assert!(apart.iter().all(|d| d.abs() < 0.1), "{found:?}, expected {expected:?}");
    }

    #[test]
    fn the_sun_is_overhead_where_almanacs_say() {
        // Solstices and equinoxes of 2026 at noon; longitudes from the equation of time (minutes / 4 degrees).
        for (days, hours, latitude, longitude) in [
            (20_532.0, 14.77, 0.0, 180.0 - 15.0 * 14.77 + 7.4 / 4.0), // 20 March, 14:46
            (20_625.0, 12.0, 23.44, 1.8 / 4.0),                       // 21 June
            (20_719.0, 0.08, 0.0, 180.0 - 15.0 * 0.08 - 7.4 / 4.0),   // 23 September, 00:05
            (20_808.0, 20.83, -23.44, 180.0 - 15.0 * 20.83 - 1.8 / 4.0), // 21 December, 20:50
            (20_761.0, 12.0, -15.5, -16.4 / 4.0),                     // 4 November: the equation of time at its greatest
            (20_495.0, 12.0, -13.97, 14.2 / 4.0),                     // 11 February: at its least
        ] {
            assert_near(subsolar_point(at(days, hours), EARTH_TILT), [latitude, longitude]);
        }
    }

    #[test]
    fn meeus_own_example_comes_out() {
        // 1992-10-13T00:00 (example 25.a): declination -7.785 degrees.
        assert!((subsolar_point(at(8321.0, 0.0), EARTH_TILT)[0] + 7.785).abs() < 0.01);
    }

    #[test]
    fn planets_without_tilt_have_no_seasons() {
        for month in 0..12 {
            assert!(subsolar_point(at(20_454.0 + 30.0 * f64::from(month), 5.0), 0.0)[0].abs() < 1e-9);
        }
        assert!(subsolar_point(at(20_625.0, 12.0), 10.0)[0] > 9.9);
    }

    #[test]
    fn the_sun_goes_west() {
        let [_, before] = subsolar_point(at(20_625.0, 12.0), EARTH_TILT);
        let [_, after] = subsolar_point(at(20_625.0, 14.0), EARTH_TILT);
        assert!((before - after - 30.0).abs() < 0.01);
        assert!((direction(at(20_625.0, 12.0), EARTH_TILT).length() - 1.0).abs() < 1e-12);
    }
}
