//! Where the viewer is and which way they face, and the moves that all cameras are made of.
//!
//! All in f64 and planet-fixed metres. The direction is kept as a tangent and a pitch, so that looking straight down, or standing
//! on a pole, is like any other site.

use super::surface::Surface;
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;
use terrane_planet::draw::view::{local_frame, Camera};
use terrane_planet::planet::CLEARANCE_M;

/// Metres by which an altitude that was set may come back lower.
const ROUNDING: f64 = 1e-6;

/// A level viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// Position from the planet's centre in metres.
    pub(super) position: DVec3,
    /// Unit vector along the ground towards where the viewer faces.
    pub(super) ahead: DVec3,
    /// Radians above the horizontal, within ±π/2.
    pub(super) pitch: f64,
}

/// Field of view and size of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    /// Vertical field of view in radians.
    pub(super) fov: f64,
    /// Picture size in pixels.
    pub(super) size: [u32; 2],
}

impl Pose {
    /// A pose of a tangent that need not be exact, and a pitch that is cut to its range.
    pub(super) fn new(position: DVec3, ahead: DVec3, pitch: f64) -> Pose {
        Pose { position, ahead, pitch: pitch.clamp(-FRAC_PI_2, FRAC_PI_2) }.levelled()
    }

    /// Looking along a unit direction. Where that is straight up or down, `ahead` says what is up in the picture.
    pub(super) fn facing(position: DVec3, direction: DVec3, ahead: DVec3) -> Pose {
        let up = position.normalize();
        let level = direction.reject_from_normalized(up);
        let ahead = if level.length() > 1e-6 { level } else { ahead };
        Pose::new(position, ahead, direction.dot(up).clamp(-1.0, 1.0).asin())
    }

    /// The pose of a level camera.
    pub(super) fn of_camera(camera: &Camera) -> Pose {
        let up = camera.position.normalize();
        let sine = camera.forward.dot(up).clamp(-1.0, 1.0);
        let cosine = camera.up.dot(up);
        let ahead = (camera.forward * cosine - camera.up * sine).normalize();
        Pose { position: camera.position, ahead, pitch: sine.atan2(cosine) }.levelled()
    }

    /// The camera of this pose.
    pub(super) fn camera(&self, lens: &Lens) -> Camera {
        let (sine, cosine) = self.pitch.sin_cos();
        let up = self.up();
        Camera {
            position: self.position,
            forward: (self.ahead * cosine + up * sine).normalize(),
            up: (up * cosine - self.ahead * sine).normalize(),
            fov: lens.fov,
            size: lens.size,
        }
    }

    /// Away from the planet's centre.
    pub(super) fn up(&self) -> DVec3 {
        self.position.normalize()
    }

    /// Metres above the surface.
    pub(super) fn altitude(&self, surface: &dyn Surface) -> f64 {
        self.position.length() - surface.radius(self.up())
    }

    /// Turns by radians to the right and upwards.
    pub(super) fn turn(&mut self, right: f64, upwards: f64) {
        self.ahead = DQuat::from_axis_angle(self.up(), -right) * self.ahead;
        self.pitch = (self.pitch + upwards).clamp(-FRAC_PI_2, FRAC_PI_2);
        *self = self.levelled();
    }

    /// Moves to a position, facing the same way as far as the ground's curve allows.
    pub(super) fn move_to(&mut self, position: DVec3) {
        self.ahead = DQuat::from_rotation_arc(self.up(), position.normalize()) * self.ahead;
        self.position = position;
        *self = self.levelled();
    }

    /// Rotates about the planet's centre, so that unit direction `from` comes to where `to` was, at most by `most` radians.
    pub(super) fn swing(&mut self, from: DVec3, to: DVec3, most: f64) {
        let whole = DQuat::from_rotation_arc(from, to);
        let angle = from.angle_between(to);
        let part = if angle > most { DQuat::IDENTITY.slerp(whole, most / angle) } else { whole };
        self.position = part * self.position;
        self.ahead = part * self.ahead;
        *self = self.levelled();
    }

    /// Rotates about the planet's centre by radians about a unit axis.
    pub(super) fn spin(&mut self, axis: DVec3, angle: f64) {
        let rotation = DQuat::from_axis_angle(axis, angle);
        self.position = rotation * self.position;
        self.ahead = rotation * self.ahead;
        *self = self.levelled();
    }

    /// Turns to a heading in radians clockwise from north, keeping the pitch.
    pub(super) fn head(&mut self, heading: f64) {
        let frame = local_frame(self.position);
        self.ahead = frame.y_axis * heading.cos() + frame.x_axis * heading.sin();
        *self = self.levelled();
    }

    /// Radians clockwise from north.
    pub(super) fn heading(&self) -> f64 {
        let frame = local_frame(self.position);
        self.ahead.dot(frame.x_axis).atan2(self.ahead.dot(frame.y_axis))
    }

    /// Moves straight up or down to an altitude in metres above the surface, no lower than [`CLEARANCE_M`].
    pub(super) fn set_altitude(&mut self, altitude_m: f64, surface: &dyn Surface) {
        let up = self.up();
        self.position = up * (surface.radius(up) + altitude_m.max(CLEARANCE_M));
    }

    /// Lifts the viewer out of the ground. Returns whether that was needed.
    pub(super) fn keep_above(&mut self, surface: &dyn Surface) -> bool {
        let below = self.altitude(surface) < CLEARANCE_M - ROUNDING;
        if below {
            self.set_altitude(CLEARANCE_M, surface);
        }
        below
    }

    /// The unit direction of what is seen at a pixel.
    pub(super) fn ray(&self, lens: &Lens, pixel: [f64; 2]) -> DVec3 {
        let camera = self.camera(lens);
        let (h, v) = camera.half_extents();
        let x = 2.0 * pixel[0] / f64::from(lens.size[0]) - 1.0;
        let y = 1.0 - 2.0 * pixel[1] / f64::from(lens.size[1]);
        (camera.forward + camera.right() * (h * x) + camera.up * (v * y)).normalize()
    }

    /// The pose with rounding errors of its tangent removed.
    fn levelled(self) -> Pose {
        let ahead = self.ahead.reject_from_normalized(self.up()).try_normalize();
        Pose { ahead: ahead.unwrap_or_else(|| self.up().any_orthonormal_vector()), ..self }
    }
}

/// Where a ray from `origin` first meets the sphere of `radius`, as a unit direction from the centre; where it passes the sphere,
/// its nearest point. None if it looks away or starts inside.
pub(super) fn meet_sphere(origin: DVec3, ray: DVec3, radius: f64) -> Option<DVec3> {
    let distance = origin.length();
    let along = -origin.dot(ray);
    if along <= 0.0 || distance <= radius {
        return None;
    }
    let inside = along * along - (distance - radius) * (distance + radius);
    (origin + ray * (along - inside.max(0.0).sqrt())).try_normalize()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) const RADIUS: f64 = 6.4e6;
    pub(crate) const LENS: Lens = Lens { fov: 0.9, size: [800, 600] };

    pub(crate) struct Ball;

    impl Surface for Ball {
        fn radius(&self, _: DVec3) -> f64 {
            RADIUS
        }

        fn meet(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
            let passes = origin.cross(direction).length() > RADIUS;
            meet_sphere(origin, direction, RADIUS).filter(|_| !passes).map(|towards| towards * RADIUS)
        }
    }

    pub(crate) fn pose(altitude_m: f64, heading: f64, pitch: f64) -> Pose {
        let position = DVec3::new(0.6, 0.48, 0.64) * (RADIUS + altitude_m);
        Pose::of_camera(&Camera::looking(position, heading, pitch, LENS.fov, LENS.size))
    }

    #[test]
    fn cameras_come_back_as_they_were() {
        for (heading, pitch) in [(0.0, 0.0), (77.0, -33.0), (200.0, 89.0), (310.0, -90.0)] {
            let camera = Camera::looking(DVec3::new(-3e6, 4e6, 5e6), heading, pitch, LENS.fov, LENS.size);
            let back = Pose::of_camera(&camera).camera(&LENS);
            assert!(back.forward.distance(camera.forward) < 1e-9 && back.up.distance(camera.up) < 1e-9, "{heading} {pitch}");
        }
    }

    #[test]
    fn moving_keeps_the_view_level() {
        let mut pose = pose(1000.0, 40.0, -20.0);
        for _ in 0..1000 {
            pose.move_to(pose.position + pose.ahead * 20e3);
            pose.turn(0.01, 0.0);
        }
        assert!(pose.ahead.dot(pose.up()).abs() < 1e-12 && (pose.ahead.length() - 1.0).abs() < 1e-12);
        assert!((pose.pitch.to_degrees() + 20.0).abs() < 1e-9);
    }

    #[test]
    fn rays_that_pass_the_planet_meet_its_limb() {
        let from = DVec3::X * 2.0;
        assert_eq!(meet_sphere(from, -DVec3::X, 1.0), Some(DVec3::X));
        let limb = meet_sphere(from, DVec3::new(-1.0, 1.0, 0.0).normalize(), 1.0).unwrap();
        assert!(limb.distance(DVec3::new(1.0, 1.0, 0.0).normalize()) < 1e-12);
        assert_eq!(meet_sphere(from, DVec3::X, 1.0), None);
        assert_eq!(meet_sphere(DVec3::X * 0.5, -DVec3::X, 1.0), None);
    }
}
