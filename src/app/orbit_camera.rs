//! The orbit camera: the ground stays under the cursor that drags it, the wheel zooms towards it, and the view tilts towards the
//! horizon on the way down.

use super::pose::{meet_sphere, Lens, Pose};
use super::surface::Surface;
use glam::DVec3;
use std::time::Instant;

/// How much of the way down or up one notch of the wheel goes, as a logarithm of altitude.
const ZOOM_PER_NOTCH: f64 = 0.2;
/// Share of an outstanding zoom that is done each second, as a rate.
const ZOOM_RATE: f64 = 12.0;
/// Outstanding zoom that is too little to be seen.
const ZOOM_DONE: f64 = 1e-6;
/// Heights in planet radii that the wheel stays below.
const HIGHEST: f64 = 40.0;
/// Pitch in degrees that a zoom tends to: near the ground, and from space.
const PITCH: [f64; 2] = [-14.0, -90.0];
/// Heights between which the pitch changes from one to the other: metres, and planet radii.
const TILT_ALTITUDES: (f64, f64) = (150.0, 0.4);
/// How fast a zoom draws the pitch to where it tends: a rate over the logarithm of altitude.
const TILT_RATE: f64 = 0.6;

/// Rate at which ground that was thrown comes to rest.
const FRICTION: f64 = 3.0;
/// Radians a second, for each metre of altitude and radius of the planet, below which it is at rest.
const AT_REST: f64 = 0.01;
/// Seconds since the last motion of the mouse after which a release throws nothing.
const HELD_STILL: f64 = 0.08;
/// Weight of the latest motion in the speed of a drag.
const RECENT: f64 = 0.5;

/// State of the orbit camera.
#[derive(Default)]
pub(super) struct OrbitCamera {
    grip: Option<Grip>,
    /// How the ground turns below the viewer: radians a second, about an axis of that length. While it is dragged, how it would if it were
    /// let go.
    spin: DVec3,
    dragged: Option<Instant>,
    /// Outstanding zoom, as a logarithm of altitude.
    zoom: f64,
}

/// The ground that is held.
#[derive(Clone, Copy)]
struct Grip {
    direction: DVec3,
    radius: f64,
}

impl OrbitCamera {
    /// Takes hold of the ground at a pixel.
    pub(super) fn press(&mut self, pose: &Pose, lens: &Lens, pixel: [f64; 2], surface: &dyn Surface) {
        self.let_go();
        self.grip = Grip::at(pose, lens, pixel, surface);
    }

    /// Lets go at a time: ground in motion goes on, slower and slower.
    pub(super) fn release(&mut self, now: Instant) {
        let still = self.dragged.is_none_or(|dragged| now.duration_since(dragged).as_secs_f64() > HELD_STILL);
        if self.grip.take().is_none() || still {
            self.spin = DVec3::ZERO;
        }
        self.dragged = None;
    }

    /// Lets go, and nothing goes on.
    pub(super) fn let_go(&mut self) {
        (self.grip, self.spin, self.dragged) = (None, DVec3::ZERO, None);
    }

    /// Brings the ground that is held to a pixel, at a time.
    pub(super) fn drag(&mut self, pose: &mut Pose, lens: &Lens, pixel: [f64; 2], now: Instant, surface: &dyn Surface) {
        let Some(grip) = self.grip else { return };
        let before = pose.up();
        grip.bring_to(pose, lens, pixel);
        let swung = before.cross(pose.up());
        if let Some(latest) = self.dragged.replace(now) {
            let seconds = now.duration_since(latest).as_secs_f64().max(1e-3);
            self.spin += (swung / seconds - self.spin) * RECENT;
        }
        pose.keep_above(surface);
    }

    /// Whether a zoom is outstanding, or ground that was thrown is not at rest.
    pub(super) fn is_moving(&self) -> bool {
        self.zoom != 0.0 || (self.grip.is_none() && self.spin != DVec3::ZERO)
    }

    /// Moves ground that was thrown on.
    fn glide(&mut self, pose: &mut Pose, seconds: f64, surface: &dyn Surface) {
        let Some(axis) = self.spin.try_normalize().filter(|_| self.grip.is_none()) else { return };
        let (rate, left) = (self.spin.length(), (-FRICTION * seconds).exp());
        pose.spin(axis, rate * (1.0 - left) / FRICTION);
        self.spin *= left;
        if rate * left * surface.radius(pose.up()) < AT_REST * pose.altitude(surface) {
            self.spin = DVec3::ZERO;
        }
        pose.keep_above(surface);
    }

    /// Asks for a zoom by notches of the wheel, towards the ground if positive.
    pub(super) fn wheel(&mut self, notches: f64) {
        self.zoom -= ZOOM_PER_NOTCH * notches;
    }

    /// Does the part of the outstanding zoom that is due after `seconds`, keeping the ground at `pixel` where it is; and moves on what was
    /// thrown.
    pub(super) fn step(&mut self, pose: &mut Pose, lens: &Lens, pixel: [f64; 2], seconds: f64, surface: &dyn Surface) {
        self.glide(pose, seconds, surface);
        if self.zoom.abs() < ZOOM_DONE {
            self.zoom = 0.0;
            return;
        }
        let part = self.zoom * (1.0 - (-ZOOM_RATE * seconds).exp());
        self.zoom -= part;
        let grip = Grip::at(pose, lens, pixel, surface);
        // Ground may have risen since the last step.
        pose.keep_above(surface);
        let radius = surface.radius(pose.up());
        let old = pose.altitude(surface);
        let new = (old * part.exp()).min(HIGHEST * radius);
        pose.set_altitude(new, surface);
        let change = (pose.altitude(surface) / old).ln();
        let before = resting_pitch(old, radius);
        let after = resting_pitch(pose.altitude(surface), radius);
        let towards = 1.0 - (-TILT_RATE * change.abs()).exp();
        let tilted = pose.pitch + after - before;
        pose.turn(0.0, tilted + (after - tilted) * towards - pose.pitch);
        if let Some(grip) = grip {
            grip.bring_to(pose, lens, pixel);
        }
        pose.keep_above(surface);
    }
}

impl Grip {
    fn at(pose: &Pose, lens: &Lens, pixel: [f64; 2], surface: &dyn Surface) -> Option<Grip> {
        let ray = pose.ray(lens, pixel);
        let met = surface.meet(pose.position, ray).filter(|point| point.length() < pose.position.length());
        if let Some(point) = met {
            return Some(Grip { direction: point.normalize(), radius: point.length() });
        }
        // The limb beside the planet, and slopes above the viewer: a sphere as high as what is below them.
        let radius = surface.radius(pose.up());
        meet_sphere(pose.position, ray, radius).map(|direction| Grip { direction, radius })
    }

    /// Swings the viewer so that this ground appears at a pixel; near the limb, where a pixel is a long way, only some of it.
    fn bring_to(self, pose: &mut Pose, lens: &Lens, pixel: [f64; 2]) {
        let ray = pose.ray(lens, pixel);
        if let Some(there) = meet_sphere(pose.position, ray, self.radius) {
            let horizon = (self.radius / pose.position.length()).min(1.0).acos();
            pose.swing(there, self.direction, horizon);
        }
    }
}

/// The pitch in radians that suits an altitude over a planet of `radius`, in metres.
pub(super) fn resting_pitch(altitude_m: f64, radius: f64) -> f64 {
    let (low, high) = (TILT_ALTITUDES.0.ln(), (TILT_ALTITUDES.1 * radius).ln());
    let t = ((altitude_m.max(1.0).ln() - low) / (high - low)).clamp(0.0, 1.0);
    let smooth = t * t * (3.0 - 2.0 * t);
    (PITCH[0] + (PITCH[1] - PITCH[0]) * smooth).to_radians()
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::{pose, Ball, LENS, RADIUS};
    use super::*;
    use terrane_planet::planet::CLEARANCE_M;

    #[test]
    fn dragged_ground_stays_under_the_cursor() {
        for (altitude_m, pitch) in [(2e7, -90.0), (3e5, -50.0), (500.0, -30.0)] {
            let mut viewer = pose(altitude_m, 30.0, pitch);
            let mut camera = OrbitCamera::default();
            camera.press(&viewer, &LENS, [300.0, 350.0], &Ball);
            let held = camera.grip.unwrap().direction;
            camera.drag(&mut viewer, &LENS, [420.0, 400.0], Instant::now(), &Ball);
            let seen = meet_sphere(viewer.position, viewer.ray(&LENS, [420.0, 400.0]), RADIUS).unwrap();
            assert!(held.distance(seen) * RADIUS < 1e-6 * altitude_m, "{altitude_m}: {}", held.distance(seen) * RADIUS);
            assert!((viewer.altitude(&Ball) - altitude_m).abs() < 1e-6 * altitude_m);
        }
    }

    #[test]
    fn a_zoom_goes_on_over_ground_that_rises_above_the_viewer() {
        struct Risen;
        impl Surface for Risen {
            fn radius(&self, _: DVec3) -> f64 {
                RADIUS + 50.0
            }
            fn meet(&self, _: DVec3, _: DVec3) -> Option<DVec3> {
                None
            }
        }
        let (mut viewer, mut camera) = (pose(20.0, 0.0, -10.0), OrbitCamera::default());
        camera.wheel(-5.0);
        camera.step(&mut viewer, &LENS, [400.0, 300.0], 0.05, &Risen);
        assert!(viewer.pitch.is_finite() && viewer.altitude(&Risen) >= CLEARANCE_M - 1e-6, "{viewer:?}");
    }

    #[test]
    fn ground_that_is_thrown_glides_on_and_ground_that_is_put_down_does_not() {
        use std::time::Duration;
        let begun = Instant::now();
        let thrown = |pause: u64| {
            let (mut viewer, mut camera) = (pose(3e5, 30.0, -60.0), OrbitCamera::default());
            camera.press(&viewer, &LENS, [400.0, 300.0], &Ball);
            for k in 1..=10u32 {
                let now = begun + Duration::from_millis(u64::from(k) * 16);
                camera.drag(&mut viewer, &LENS, [400.0 + 8.0 * f64::from(k), 300.0], now, &Ball);
            }
            let left = viewer.up();
            camera.release(begun + Duration::from_millis(160 + pause));
            let mut frames = 0;
            while camera.is_moving() {
                camera.step(&mut viewer, &LENS, [480.0, 300.0], 0.02, &Ball);
                frames += 1;
            }
            (frames, left.angle_between(viewer.up()) * RADIUS / 3e5)
        };
        assert_eq!(thrown(200), (0, 0.0));
        let (frames, way) = thrown(10);
        assert!((20..250).contains(&frames) && (0.05..2.0).contains(&way), "{frames} frames, {way} altitudes");
    }

    #[test]
    fn zooming_is_the_same_at_any_frame_rate() {
        let zoomed = |steps: usize| {
            let mut viewer = pose(1e6, 0.0, -70.0);
            let mut camera = OrbitCamera::default();
            camera.wheel(2.0 / ZOOM_PER_NOTCH);
            (0..steps).for_each(|_| camera.step(&mut viewer, &LENS, [400.0, 300.0], 1.0 / steps as f64, &Ball));
            viewer
        };
        let (fast, slow) = (zoomed(240), zoomed(15));
        assert!((fast.altitude(&Ball) / slow.altitude(&Ball) - 1.0).abs() < 1e-6);
        assert!((fast.altitude(&Ball) / (1e6 * (-2.0f64).exp()) - 1.0).abs() < 1e-3);
        assert!((fast.pitch - slow.pitch).abs() < 0.02);
    }

    #[test]
    fn zooming_down_ends_above_the_ground_with_the_horizon_in_sight() {
        let mut viewer = pose(2e7, 0.0, -90.0);
        let mut camera = OrbitCamera::default();
        camera.wheel(300.0);
        (0..600).for_each(|_| camera.step(&mut viewer, &LENS, [410.0, 290.0], 0.05, &Ball));
        assert!((viewer.altitude(&Ball) - CLEARANCE_M).abs() < 1e-6, "{}", viewer.altitude(&Ball));
        assert!((-20.0..-10.0).contains(&viewer.pitch.to_degrees()), "{}", viewer.pitch.to_degrees());
    }
}
