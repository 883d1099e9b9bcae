//! The viewer: the pose, the two cameras that move it, and what mouse and keys do to them.

use super::fly_camera::FlyCamera;
use super::keys::Held;
use super::orbit_camera::OrbitCamera;
use super::pose::{Lens, Pose};
use super::surface::Surface;
use glam::DVec3;
use terrane_planet::draw::view::Camera;

/// How far the view turns when the mouse moves by a pixel, in angles that a pixel subtends.
const LOOK_GAIN: f64 = 1.5;

/// A mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Button {
    /// Drags the ground, or looks around in free flight.
    Left,
    /// Looks around.
    Right,
}

/// Pose, cameras and input.
pub(super) struct Viewer {
    /// Where the viewer is.
    pub(super) pose: Pose,
    /// Field of view and picture size.
    pub(super) lens: Lens,
    /// Keys held down.
    pub(super) held: Held,
    /// Whether in free flight; otherwise in orbit.
    pub(super) flying: bool,
    orbit: OrbitCamera,
    flight: FlyCamera,
    cursor: [f64; 2],
    button: Option<Button>,
}

impl Viewer {
    /// A viewer at a camera.
    pub(super) fn new(camera: &Camera) -> Viewer {
        let lens = Lens { fov: camera.fov, size: camera.size };
        Viewer {
            pose: Pose::of_camera(camera),
            lens,
            held: Held::default(),
            flying: false,
            orbit: OrbitCamera::default(),
            flight: FlyCamera::default(),
            cursor: lens.size.map(|side| f64::from(side) / 2.0),
            button: None,
        }
    }

    /// Changes cameras, keeping the pose.
    pub(super) fn switch_camera(&mut self) {
        self.flying = !self.flying;
        self.orbit = OrbitCamera::default();
        self.flight = FlyCamera::default();
        self.button = None;
    }

    /// A mouse button went down, or up.
    pub(super) fn press(&mut self, button: Button, down: bool, surface: &dyn Surface) {
        self.orbit.release();
        self.button = down.then_some(button);
        if self.button == Some(Button::Left) && !self.flying {
            self.orbit.press(&self.pose, &self.lens, self.cursor, surface);
        }
    }

    /// The mouse moved to a pixel.
    pub(super) fn point(&mut self, pixel: [f64; 2], surface: &dyn Surface) {
        let moved = [pixel[0] - self.cursor[0], pixel[1] - self.cursor[1]];
        self.cursor = pixel;
        match self.button {
            None => {}
            Some(Button::Left) if !self.flying => {
                self.orbit.drag(&mut self.pose, &self.lens, pixel, surface);
            }
            Some(_) => {
                let angle = LOOK_GAIN * self.pose.camera(&self.lens).pixel_angle();
                self.pose.turn(moved[0] * angle, -moved[1] * angle);
            }
        }
    }

    /// The wheel turned.
    pub(super) fn wheel(&mut self, notches: f64) {
        if !self.flying {
            self.orbit.wheel(notches);
        }
    }

    /// Lets go of everything, as when the window loses the keyboard.
    pub(super) fn let_go(&mut self) {
        self.held.clear();
        self.orbit.release();
        self.button = None;
    }

    /// Whether the viewer moves by themselves: keys are held, or a motion goes on.
    pub(super) fn is_moving(&self) -> bool {
        if self.flying {
            self.held.wish() != DVec3::ZERO || self.flight.is_moving()
        } else {
            self.orbit.is_moving()
        }
    }

    /// Moves on by so many seconds.
    pub(super) fn step(&mut self, seconds: f64, surface: &dyn Surface) {
        if self.flying {
            self.flight.step(&mut self.pose, self.held.wish(), self.held.hurry(), seconds, surface);
        } else {
            self.orbit.step(&mut self.pose, &self.lens, self.cursor, seconds, surface);
        }
        self.rise(surface);
    }

    /// Lifts the viewer out of ground that has changed. Returns whether that was needed.
    pub(super) fn rise(&mut self, surface: &dyn Surface) -> bool {
        self.pose.keep_above(surface)
    }

    /// Metres above ground or sea.
    pub(super) fn altitude(&self, surface: &dyn Surface) -> f64 {
        self.pose.altitude(surface)
    }
}
