//! What keys and the panel ask for, done. In: commands and what was chosen. Out: a flight that follows them.

use super::destination::Destination;
use super::flight::{Flight, Screenshot, Selection};
use super::keys::{next_mode, Command};
use super::orbit_camera::resting_pitch;
use super::panel::Asked;
use super::pose::Pose;
use super::surface::{DrawnSurface, Surface};
use glam::DQuat;
use terrane_planet::draw::layout::Mode;
use terrane_planet::draw::view::{local_frame, Camera};
use terrane_planet::draw::view_line::Stand;
use terrane_planet::globe::sphere::direction_at;
use winit::window::Fullscreen;

/// Radians that the sun moves along its daily course with each key press.
const SUN_STEP: f64 = 0.05;
/// Altitude in planet radii that a place is gone to without one of its own, unless the viewer is lower already.
const ARRIVAL: f64 = 0.01;

impl Flight {
    /// Does what a key asks for, other than ending and what goes to the user.
    pub(super) fn obey(&mut self, command: Command) {
        let surface = &DrawnSurface::of_scene(&self.scene, self.choices.look.sea);
        let look = &mut self.choices.look;
        match command {
            Command::Quit | Command::CopyView | Command::Bookmark => {}
            Command::Help => self.panel.help = !self.panel.help,
            Command::Panel => self.panel.open = !self.panel.open,
            Command::Hide => self.panel.hidden = !self.panel.hidden,
            Command::GoTo => self.panel.ask_where(),
            Command::SwitchCamera => self.viewer.set_manner(self.viewer.manner().next()),
            Command::Home => self.viewer.fly_to(self.home, surface),
            Command::North => {
                let mut pose = self.viewer.pose;
                pose.head(0.0);
                self.viewer.turn_to(pose, surface);
            }
            Command::Horizon => {
                let pose = self.viewer.pose;
                let radius = surface.radius(pose.up());
                let dip = (radius / pose.position.length()).min(1.0).acos();
                self.viewer.turn_to(Pose::new(pose.position, pose.ahead, -dip), surface);
            }
            Command::Back | Command::Forward => {
                if !self.viewer.revisit(command == Command::Back, surface) {
                    self.panel.say("no place to go to: double click, or go to one first".to_owned());
                }
            }
            Command::Show(mode) => look.mode = mode,
            Command::ShowNext => look.mode = next_mode(look.mode),
            Command::Toggle(mode) => look.mode = if look.mode == mode { Mode::Shaded } else { mode },
            Command::Geomorphs => self.choices.geomorphs = !self.choices.geomorphs,
            Command::Freeze if self.selection == Selection::Follows => self.selection = Selection::Freezes,
            Command::Freeze => self.selection = Selection::Follows,
            Command::Screenshot(of_window) => {
                self.screenshot = Some(if of_window { Screenshot::Window } else { Screenshot::Picture });
            }
            Command::Fullscreen => {
                let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(full);
            }
            Command::Clouds => look.clouds = !look.clouds,
            Command::Sun(steps) => look.sun = DQuat::from_rotation_z(-SUN_STEP * steps) * look.sun,
            Command::Zoom(notches) => self.viewer.wheel(notches),
        }
        self.touch();
    }

    /// Does what the panel was asked for; its commands are done with those of the keys.
    pub(super) fn answer(&mut self, asked: Asked) {
        let Asked { commands, destination, manner, speed, fov } = asked;
        if let Some(destination) = destination {
            self.go_to(&destination);
        }
        if let Some(manner) = manner {
            self.viewer.set_manner(manner);
        }
        self.viewer.speed = speed.unwrap_or(self.viewer.speed);
        if let Some(degrees) = fov {
            self.viewer.lens.fov = degrees.to_radians();
            self.touch();
        }
        self.wishes.extend(commands);
    }

    /// Flies to a place.
    pub(super) fn go_to(&mut self, destination: &Destination) {
        let pose = self.pose_at(destination);
        self.viewer.fly_to(pose, &DrawnSurface::of_scene(&self.scene, self.choices.look.sea));
        self.touch();
    }

    /// Where a viewer stands at a place, as far as the ground there is known.
    fn pose_at(&self, destination: &Destination) -> Pose {
        let planet = self.scene.planet();
        let direction = direction_at(destination.at[0], destination.at[1]);
        let radius = planet.recipe.radius;
        let usual = || self.viewer.altitude(&self.surface()).min(ARRIVAL * radius);
        let height = match destination.stand {
            Some(Stand::Height(metres)) => metres,
            Some(Stand::Altitude(metres)) => planet.surface_height(direction) + metres,
            None => planet.surface_height(direction) + usual(),
        };
        let position = direction * (radius + height);
        match destination.look {
            Some([heading, pitch]) => {
                Pose::of_camera(&Camera::looking(position, heading, pitch, self.viewer.lens.fov, self.viewer.lens.size))
            }
            None => Pose::new(position, local_frame(position).y_axis, resting_pitch(height, radius)),
        }
    }
}
