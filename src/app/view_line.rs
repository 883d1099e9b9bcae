//! What a window shows, as a view of one line. In: the viewer and the look. Out: numbers rounded to what nobody sees.

use super::viewer::Viewer;
use crate::frame::{sun_seen_from, Look};
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view_line::{Daylight, Exposure, Stand, ViewLine};
use terrane_planet::globe::sphere::latitude_longitude;

/// Digits behind the point of degrees on the ground (0.1 mm on an Earth), of angles of view, of the sun's, of metres, and of seconds.
const SITE: i32 = 9;
const ANGLE: i32 = 6;
const SUN: i32 = 4;
const METRES: i32 = 4;
const SECONDS: i32 = 3;

/// A view with the viewer, over a planet of `radius` metres, and the look put in.
pub(super) fn of(line: ViewLine, viewer: &Viewer, radius: f64, look: &Look) -> ViewLine {
    let (pose, lens) = (&viewer.pose, &viewer.lens);
    let (latitude, longitude) = latitude_longitude(pose.up());
    let heading = pose.heading().to_degrees();
    let sun = sun_seen_from(pose.up(), look.sun);
    ViewLine {
        at: [latitude, longitude].map(|degrees| rounded(degrees, SITE)),
        stand: Stand::Height(rounded(pose.position.length() - radius, METRES)),
        look: Some([heading, pose.pitch.to_degrees()].map(|degrees| rounded(degrees, ANGLE))),
        fov: Some(rounded(lens.fov.to_degrees(), ANGLE)),
        size: Some(lens.size),
        daylight: Some(Daylight::Over(sun.map(|degrees| rounded(degrees, SUN)))),
        exposure: Some(look.metering.map_or(Exposure::Fixed(look.exposure), |_| Exposure::Auto)),
        mode: Some(look.mode).filter(|mode| *mode != Mode::Shaded),
        tone: Some(look.tone).filter(|tone| *tone != Tone::Neutral),
        time: line.time.map(|seconds| rounded(seconds, SECONDS)).filter(|seconds| *seconds > 0.0),
        clear_sky: !look.clouds,
        no_sea: !look.sea,
        no_air: !look.air,
        no_shadows: !look.shadows,
        ..line
    }
}

fn rounded(number: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    // Zero has no sign in text.
    (number * unit).round() / unit + 0.0
}

#[cfg(test)]
mod tests {
    use super::super::keys::Keys;
    use super::*;
    use glam::DVec3;
    use terrane_planet::draw::view::Camera;
    use terrane_planet::globe::sphere::direction_at;

    #[test]
    fn what_a_line_says_comes_back_from_its_camera() {
        for (latitude, longitude, heading, pitch) in
            [(-38.95, 34.34, 120.0, -11.5), (90.0, 0.0, 30.0, -90.0), (0.0, 180.0, 0.0, 45.0)]
        {
            let mut line = ViewLine::from_site([latitude, longitude], Stand::Height(1234.5));
            line.look = Some([heading, pitch]);
            line.fov = Some(50.0);
            line.size = Some([320, 240]);
            line.error = Some(1.0);
            line.exposure = Some(Exposure::Fixed(0.5));
            let position = direction_at(latitude, longitude) * (6e6 + 1234.5);
            let camera = Camera::looking(position, heading, pitch, 50f64.to_radians(), [320, 240]);
            let look = Look { exposure: 0.5, ..Look::daylight(DVec3::X) };
            let found = of(line.clone(), &Viewer::new(&camera, Keys::default()), 6e6, &look);
            let sun = found.daylight;
            assert_eq!(ViewLine { daylight: None, ..found }, line);
            assert!(matches!(sun, Some(Daylight::Over(_))));
        }
    }
}
