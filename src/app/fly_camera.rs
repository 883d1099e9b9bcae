//! Free flight: as fast as the viewer is high, smooth, and never into the ground.

use super::pose::Pose;
use super::surface::Surface;
use glam::DVec3;

/// Metres per second for each metre above the surface.
const SPEED_PER_ALTITUDE: f64 = 0.9;
/// Slowest speed in metres per second, on foot.
const LEAST_SPEED: f64 = 4.0;
/// Factor while hurrying.
const HURRY: f64 = 5.0;
/// Rate at which the velocity follows the keys.
const RESPONSE: f64 = 7.0;
/// Longest step of the simulation in seconds; longer frames are cut up, so that flight is the same at any frame rate.
const LONGEST_STEP: f64 = 0.01;
/// Below this part of the wished speed the viewer stands still.
const STILL: f64 = 1e-3;

/// State of free flight.
#[derive(Default)]
pub(super) struct FlyCamera {
    /// Speed as a share of the full speed: to the right, up and ahead of the viewer.
    pace: DVec3,
}

impl FlyCamera {
    /// Whether the viewer has not come to rest yet.
    pub(super) fn is_moving(&self) -> bool {
        self.pace != DVec3::ZERO
    }

    /// Moves the viewer for `seconds`, at a factor of the usual speed. The wish says where to, right, up and ahead, each from -1 to 1, and
    /// whether to hurry.
    pub(super) fn step(
        &mut self,
        pose: &mut Pose,
        (wish, hurry): (DVec3, bool),
        speed: f64,
        seconds: f64,
        surface: &dyn Surface,
    ) {
        let wish = wish.clamp_length_max(1.0) * if hurry { HURRY } else { 1.0 };
        if wish == DVec3::ZERO && self.pace.length() < STILL {
            self.pace = DVec3::ZERO;
            return;
        }
        let steps = (seconds / LONGEST_STEP).ceil().max(1.0);
        let part = seconds / steps;
        for _ in 0..steps as u32 {
            self.pace += (wish - self.pace) * (1.0 - (-RESPONSE * part).exp());
            let speed = (pose.altitude(surface) * SPEED_PER_ALTITUDE).max(LEAST_SPEED) * speed;
            let (sine, cosine) = pose.pitch.sin_cos();
            let (up, ahead) = (pose.up(), pose.ahead);
            let forward = ahead * cosine + up * sine;
            let velocity = (ahead.cross(up) * self.pace.x + up * self.pace.y + forward * self.pace.z) * speed;
            pose.move_to(pose.position + velocity * part);
            pose.keep_above(surface);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::{pose, Ball};
    use super::*;
    use terrane_planet::planet::CLEARANCE_M;

    fn flown(steps: usize, wish: DVec3) -> Pose {
        let mut viewer = pose(5000.0, 30.0, -10.0);
        let mut camera = FlyCamera::default();
        (0..steps).for_each(|_| camera.step(&mut viewer, (wish, false), 1.0, 2.0 / steps as f64, &Ball));
        viewer
    }

    #[test]
    fn flight_is_the_same_at_any_frame_rate() {
        let wish = DVec3::new(0.3, 0.0, 1.0);
        let (fast, slow) = (flown(480, wish), flown(20, wish));
        let length = fast.position.distance(pose(5000.0, 30.0, -10.0).position);
        assert!(length > 4000.0 && fast.position.distance(slow.position) < 0.01 * length, "{length}");
    }

    #[test]
    fn flying_into_the_ground_ends_above_it() {
        let mut viewer = pose(50.0, 0.0, -60.0);
        let mut camera = FlyCamera::default();
        for _ in 0..100 {
            camera.step(&mut viewer, (DVec3::Z, true), 1.0, 0.2, &Ball);
            assert!(viewer.altitude(&Ball) >= CLEARANCE_M - 1e-6);
        }
        assert!((viewer.altitude(&Ball) - CLEARANCE_M).abs() < 1e-6);
    }

    #[test]
    fn right_is_to_the_right() {
        let start = pose(5000.0, 0.0, 0.0);
        let east = DVec3::Z.cross(start.up()).normalize();
        assert!((flown(10, DVec3::X).position - start.position).dot(start.ahead.cross(start.up())) > 0.0);
        assert!(start.ahead.cross(start.up()).distance(east) < 1e-9);
    }
}
