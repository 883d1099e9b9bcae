//! The viewer: the pose, the cameras that move it, and what mouse and keys do to them.

use super::fly_camera::FlyCamera;
use super::history::History;
use super::journey::Journey;
use super::keys::{Held, Keys};
use super::orbit_camera::OrbitCamera;
use super::pose::{Lens, Pose};
use super::surface::Surface;
use super::walk_camera::WalkCamera;
use glam::DVec3;
use std::time::{Duration, Instant};
use terrane_planet::draw::view::Camera;

/// How far the view turns when the mouse moves by a pixel, in angles that a pixel subtends.
const LOOK_GAIN: f64 = 1.5;
/// Longest time between the presses of a double click, and the most pixels between them.
const DOUBLE: (Duration, f64) = (Duration::from_millis(400), 6.0);
/// How much nearer a double click brings what was clicked.
const APPROACH: f64 = 0.2;
/// Metres from what was clicked that the viewer stays away.
const LEAST_DISTANCE: f64 = 12.0;
/// Factor of the speed with each notch of the wheel, and its range.
const SPEED_PER_NOTCH: f64 = 1.25;
const SPEEDS: (f64, f64) = (0.01, 100.0);

/// A mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Button {
    /// Drags the ground, or looks around in free flight.
    Left,
    /// Looks around.
    Right,
}

/// Which camera moves the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Manner {
    /// The ground is dragged, and zoomed to.
    #[default]
    Orbit,
    /// Anywhere above the ground.
    Flight,
    /// On the ground.
    Walk,
}

impl Manner {
    pub(super) const ALL: [Manner; 3] = [Manner::Orbit, Manner::Flight, Manner::Walk];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Manner::Orbit => "orbit",
            Manner::Flight => "free flight",
            Manner::Walk => "walk",
        }
    }

    pub(super) fn next(self) -> Manner {
        match self {
            Manner::Orbit => Manner::Flight,
            Manner::Flight => Manner::Walk,
            Manner::Walk => Manner::Orbit,
        }
    }
}

/// Pose, cameras and input.
pub(super) struct Viewer {
    /// Where the viewer is.
    pub(super) pose: Pose,
    /// Field of view and picture size.
    pub(super) lens: Lens,
    /// Keys held down.
    pub(super) held: Held,
    /// What they mean.
    pub(super) keys: Keys,
    /// Places that the viewer flew to.
    pub(super) history: History,
    manner: Manner,
    /// Factor of the speed of free flight and of walking.
    speed: f64,
    orbit: OrbitCamera,
    flight: FlyCamera,
    walk: WalkCamera,
    journey: Option<Journey>,
    cursor: [f64; 2],
    button: Option<Button>,
    pressed: Option<(Instant, [f64; 2])>,
}

impl Viewer {
    /// A viewer at a camera.
    pub(super) fn new(camera: &Camera, keys: Keys) -> Viewer {
        let lens = Lens { fov: camera.fov, size: camera.size };
        let pose = Pose::of_camera(camera);
        Viewer {
            pose,
            lens,
            held: Held::default(),
            keys,
            history: History::default(),
            manner: Manner::Orbit,
            speed: 1.0,
            orbit: OrbitCamera::default(),
            flight: FlyCamera::default(),
            walk: WalkCamera::default(),
            journey: None,
            cursor: lens.size.map(|side| f64::from(side) / 2.0),
            button: None,
            pressed: None,
        }
    }

    /// Is at a camera all at once, in orbit, as over another planet: places before are forgotten.
    pub(super) fn appear(&mut self, camera: &Camera) {
        self.rest();
        (self.pose, self.lens) = (Pose::of_camera(camera), Lens { fov: camera.fov, size: camera.size });
        (self.manner, self.history) = (Manner::Orbit, History::default());
    }

    /// Which camera moves the viewer.
    pub(super) fn manner(&self) -> Manner {
        self.manner
    }

    /// Changes cameras, keeping the pose.
    pub(super) fn set_manner(&mut self, manner: Manner) {
        self.manner = manner;
        self.rest();
    }

    /// Where the cursor is, in pixels.
    pub(super) fn cursor(&self) -> [f64; 2] {
        self.cursor
    }

    /// Lets the latest click be no part of a double click.
    pub(super) fn forget_click(&mut self) {
        self.pressed = None;
    }

    /// The ground or sea under the cursor, as a unit direction from the planet's centre. None where there is none.
    pub(super) fn site_under_cursor(&self, surface: &dyn Surface) -> Option<DVec3> {
        surface.meet(self.pose.position, self.pose.ray(&self.lens, self.cursor)).map(DVec3::normalize)
    }

    /// Factor of the speed of free flight and of walking.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Sets it, as far as it is a speed.
    pub(super) fn set_speed(&mut self, speed: f64) {
        self.speed = if speed.is_finite() { speed.clamp(SPEEDS.0, SPEEDS.1) } else { 1.0 };
    }

    /// Ends all motion.
    pub(super) fn rest(&mut self) {
        self.orbit = OrbitCamera::default();
        self.flight = FlyCamera::default();
        self.walk = WalkCamera::default();
        self.journey = None;
        self.button = None;
    }

    /// Flies to a pose, which is remembered as a place.
    pub(super) fn fly_to(&mut self, to: Pose, surface: &dyn Surface) {
        self.history.visit(self.pose, to);
        self.travel(to, surface);
    }

    /// Flies to the place before, or after, that the viewer flew to. False if there is none.
    pub(super) fn revisit(&mut self, back: bool, surface: &dyn Surface) -> bool {
        let place = if back { self.history.back(self.pose) } else { self.history.forward() };
        place.map(|to| self.travel(to, surface)).is_some()
    }

    /// Turns smoothly to face as a pose does, from where the viewer is.
    pub(super) fn turn_to(&mut self, to: Pose, surface: &dyn Surface) {
        self.journey = Some(Journey::new(self.pose, to, surface));
    }

    fn travel(&mut self, to: Pose, surface: &dyn Surface) {
        self.rest();
        if self.manner == Manner::Walk {
            self.manner = Manner::Orbit;
        }
        let mut to = to;
        to.keep_above(surface);
        self.journey = Some(Journey::new(self.pose, to, surface));
    }

    /// A mouse button went down, or up, at a time. A second press at once flies to what is there.
    pub(super) fn press(&mut self, button: Button, down: bool, now: Instant, surface: &dyn Surface) {
        if !down {
            self.orbit.release(now);
            self.button = None;
            return;
        }
        self.journey = None;
        self.button = Some(button);
        if button != Button::Left {
            return;
        }
        let [x, y] = self.cursor;
        let again = self
            .pressed
            .replace((now, self.cursor))
            .is_some_and(|(before, [u, v])| now.duration_since(before) < DOUBLE.0 && (x - u).hypot(y - v) < DOUBLE.1);
        if again {
            self.pressed = None;
            self.approach(surface);
        } else if self.manner == Manner::Orbit {
            self.orbit.press(&self.pose, &self.lens, self.cursor, surface);
        }
    }

    /// Flies nearer to what is under the cursor, until it is in the middle.
    fn approach(&mut self, surface: &dyn Surface) {
        let ray = self.pose.ray(&self.lens, self.cursor);
        let Some(point) = surface.meet(self.pose.position, ray) else { return };
        let distance = (APPROACH * point.distance(self.pose.position)).max(LEAST_DISTANCE);
        self.fly_to(Pose::facing(point - ray * distance, ray, self.pose.ahead), surface);
    }

    /// The mouse moved to a pixel.
    pub(super) fn point(&mut self, pixel: [f64; 2], now: Instant, surface: &dyn Surface) {
        let moved = [pixel[0] - self.cursor[0], pixel[1] - self.cursor[1]];
        self.cursor = pixel;
        match self.button {
            None => {}
            Some(Button::Left) if self.manner == Manner::Orbit => {
                self.orbit.drag(&mut self.pose, &self.lens, pixel, now, surface);
            }
            Some(_) => {
                let angle = LOOK_GAIN * self.pose.camera(&self.lens).pixel_angle();
                self.pose.turn(moved[0] * angle, -moved[1] * angle);
            }
        }
    }

    /// The wheel turned.
    pub(super) fn wheel(&mut self, notches: f64) {
        self.journey = None;
        if self.manner == Manner::Orbit {
            self.orbit.wheel(notches);
        } else {
            self.set_speed(self.speed * SPEED_PER_NOTCH.powf(notches));
        }
    }

    /// Lets go of everything, as when the window loses the keyboard.
    pub(super) fn let_go(&mut self) {
        self.held.clear();
        self.orbit.let_go();
        self.button = None;
    }

    /// Whether the viewer moves by themselves: keys are held, or a motion goes on.
    pub(super) fn is_moving(&self) -> bool {
        let wishes = || self.keys.wish(&self.held) != DVec3::ZERO;
        self.journey.is_some()
            || match self.manner {
                Manner::Orbit => self.orbit.is_moving(),
                Manner::Flight => wishes() || self.flight.is_moving(),
                Manner::Walk => wishes() || self.walk.is_moving(),
            }
    }

    /// Moves on by so many seconds.
    pub(super) fn step(&mut self, seconds: f64, surface: &dyn Surface) {
        let (wish, hurry) = (self.keys.wish(&self.held), self.keys.hurries(&self.held));
        // Who moves themselves has changed their mind.
        if wish != DVec3::ZERO && self.manner != Manner::Orbit {
            self.journey = None;
        }
        if let Some(journey) = &mut self.journey {
            match journey.step(seconds) {
                Some(pose) => self.pose = pose,
                None => self.journey = None,
            }
        } else {
            match self.manner {
                Manner::Orbit => self.orbit.step(&mut self.pose, &self.lens, self.cursor, seconds, surface),
                Manner::Flight => self.flight.step(&mut self.pose, (wish, hurry), self.speed, seconds, surface),
                Manner::Walk => self.walk.step(&mut self.pose, (wish, hurry), self.speed, seconds, surface),
            }
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
