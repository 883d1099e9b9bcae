//! On foot: along the ground, at the height of a person's eyes.

use super::pose::Pose;
use super::surface::Surface;
use glam::DVec3;

/// Metres of the eye above the ground or the sea.
const EYE: f64 = 1.7;
/// Metres per second on foot, and for each metre that the viewer still is above the ground on the way down.
const SPEED: f64 = 1.6;
const SPEED_PER_ALTITUDE: f64 = 0.9;
/// Factor while hurrying.
const HURRY: f64 = 4.0;
/// Rate at which the pace follows the keys.
const RESPONSE: f64 = 9.0;
/// Rate at which the eye comes to its height, and the metres from there that count as being there.
const SETTLING: f64 = 4.0;
const SETTLED: f64 = 1e-3;
/// Longest step of the simulation in seconds.
const LONGEST_STEP: f64 = 0.01;
/// Below this part of the wished pace the viewer stands still.
const STILL: f64 = 1e-3;

/// State of walking.
#[derive(Default)]
pub(super) struct WalkCamera {
    /// Pace as a share of the full one: to the right, and ahead.
    pace: [f64; 2],
    /// Metres that the eye has to go up or down still.
    off: f64,
}

impl WalkCamera {
    /// Whether the viewer has not come to rest yet.
    pub(super) fn is_moving(&self) -> bool {
        self.pace != [0.0; 2] || self.off.abs() > SETTLED
    }

    /// Moves the viewer for `seconds`. The wish says where to, right, up and ahead, each from -1 to 1, and whether to hurry.
    pub(super) fn step(
        &mut self,
        pose: &mut Pose,
        (wish, hurry): (DVec3, bool),
        speed: f64,
        seconds: f64,
        surface: &dyn Surface,
    ) {
        let towards = DVec3::new(wish.x, 0.0, wish.z).clamp_length_max(1.0) * if hurry { HURRY } else { 1.0 };
        let steps = (seconds / LONGEST_STEP).ceil().max(1.0);
        let part = seconds / steps;
        for _ in 0..steps as u32 {
            for (pace, wished) in self.pace.iter_mut().zip([towards.x, towards.z]) {
                *pace += (wished - *pace) * (1.0 - (-RESPONSE * part).exp());
                if wished == 0.0 && pace.abs() < STILL {
                    *pace = 0.0;
                }
            }
            let altitude = pose.altitude(surface);
            let metres = (SPEED_PER_ALTITUDE * (altitude - EYE)).max(SPEED) * speed * part;
            let right = pose.ahead.cross(pose.up());
            pose.move_to(pose.position + (right * self.pace[0] + pose.ahead * self.pace[1]) * metres);
            // Down in a few seconds from anywhere, and smoothly over what the ground does underfoot.
            let here = pose.altitude(surface);
            pose.set_altitude(EYE + (here - EYE) * (-SETTLING * part).exp(), surface);
        }
        self.off = pose.altitude(surface) - EYE;
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::{pose, Ball};
    use super::*;

    #[test]
    fn who_begins_to_walk_in_the_air_comes_down_and_stays_at_eye_height() {
        let mut viewer = pose(20_000.0, 30.0, -10.0);
        let mut camera = WalkCamera::default();
        (0..100).for_each(|_| camera.step(&mut viewer, (DVec3::ZERO, false), 1.0, 0.05, &Ball));
        assert!(
            (viewer.altitude(&Ball) - EYE).abs() < 0.01
                && (0..40).all(|_| {
                    camera.step(&mut viewer, (DVec3::Z, true), 1.0, 0.05, &Ball);
                    (viewer.altitude(&Ball) - EYE).abs() < 0.01
                })
        );
        (0..100).for_each(|_| camera.step(&mut viewer, (DVec3::ZERO, false), 1.0, 0.05, &Ball));
        assert!(!camera.is_moving());
    }

    #[test]
    fn a_minute_on_foot_is_a_hundred_metres_at_any_frame_rate_wherever_one_looks() {
        for steps in [60, 6000] {
            let mut viewer = pose(EYE, 30.0, 80.0);
            let (begun, mut camera) = (viewer.position, WalkCamera::default());
            (0..steps).for_each(|_| camera.step(&mut viewer, (DVec3::Z, false), 1.0, 60.0 / f64::from(steps), &Ball));
            assert!((viewer.position.distance(begun) - 96.0).abs() < 1.0, "{}", viewer.position.distance(begun));
        }
    }
}
