//! What keys and the panel ask for, done. In: commands and what was chosen. Out: a flight that follows them.

use super::choices::Choices;
use super::destination::Site;
use super::earthwork::STILL;
use super::flight::{Flight, Screenshot, Selection, USUAL_TOLERANCE};
use super::host::Settings;
use super::keys::{next_mode, Command};
use super::orbit_camera::resting_pitch;
use super::panel::{Asked, PathWish};
use super::playback::Playback;
use super::pose::Pose;
use super::storyboard::Revision;
use super::surface::{DrawnSurface, Surface};
use crate::frame::{sun_over, sun_seen_from, Look};
use crate::scene::EditRequest;
use glam::DQuat;
use terrane_planet::draw::camera_path::{Keyframe, Waypoint};
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view::{local_frame, Camera};
use terrane_planet::draw::view_line::{Daylight, Exposure, Stand, ViewLine};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::globe::sun;
use terrane_planet::planet::CLEARANCE_M;
use winit::window::Fullscreen;

/// Radians that the sun moves along its daily course with each key press.
const SUN_STEP: f64 = 0.05;
/// Altitude in planet radii that a place is gone to without one of its own, unless the viewer is lower already.
const ARRIVAL: f64 = 0.01;

impl Flight {
    /// Does what a key asks for, other than ending and what goes to the user.
    pub(super) fn obey(&mut self, command: Command) {
        if matches!(command, Command::Home | Command::North | Command::Horizon | Command::Back | Command::Forward) {
            self.stop_playing();
        }
        let surface = &DrawnSurface::of_scene(&self.scene, self.choices.look.sea);
        let look = &mut self.choices.look;
        match command {
            Command::Quit | Command::CopyView => {}
            Command::Bookmark => self.screenshot = Some(Screenshot::Bookmark),
            Command::Help => self.panel.toggle_help(),
            Command::Panel => self.panel.toggle(),
            Command::Hide => self.panel.hidden = !self.panel.hidden,
            Command::GoTo => self.panel.ask_where(),
            Command::SwitchCamera => self.viewer.set_manner(self.viewer.manner().next()),
            Command::Home => self.fly_to(self.home),
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
            Command::AddKeyframe => self.revise(Revision::Add),
            Command::Play => self.play(),
            Command::Film => self.asked.path = Some(PathWish::Film(self.panel.path_name())),
            Command::Tool => {
                self.panel.tool.held = !self.panel.tool.held;
                let said = if self.panel.tool.held {
                    "a click changes the ground: radius and depth are in the panel"
                } else {
                    "the tool is put away"
                };
                self.panel.say(said.to_owned());
            }
            Command::Undo => self.edit(EditRequest::Undo),
            Command::Redo => self.edit(EditRequest::Redo),
            Command::Inspect if self.picked.is_some() => self.picked = None,
            Command::Inspect => {
                self.picked = self.viewer.site_under_cursor(surface);
                if self.picked.is_none() {
                    self.panel.say("nothing is there: put the cursor on the planet".to_owned());
                }
            }
            Command::Fullscreen => {
                let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(full);
            }
            Command::Clouds => look.clouds = !look.clouds,
            Command::Sun(steps) => {
                look.sun = DQuat::from_rotation_z(-SUN_STEP * steps) * look.sun;
                self.choices.date = None;
            }
            Command::Zoom(notches) => self.viewer.wheel(notches),
        }
        self.touch();
    }

    /// The left button went down, or up. A click with the tool in hand changes the ground.
    pub(super) fn work_ground(&mut self, down: bool) {
        if down {
            self.put_down = self.panel.tool.held.then_some(self.viewer.cursor());
            return;
        }
        let [x, y] = self.viewer.cursor();
        if self.put_down.take().is_none_or(|[u, v]| (x - u).hypot(y - v) > STILL) {
            return;
        }
        self.viewer.forget_click();
        let Some(site) = self.viewer.site_under_cursor(&self.surface()) else { return };
        let request = self.panel.tool.request(self.scene.planet(), site);
        self.edit(request);
    }

    /// Changes the keyframes of the path.
    fn revise(&mut self, revision: Revision) {
        let here = self.keyframe();
        self.panel.board.revise(revision, here);
        if revision == Revision::Add {
            let count = self.panel.board.keyframes().len();
            let play = self.viewer.keys.of_command(Command::Play);
            self.panel.say(if count < 2 {
                format!("{count} keyframe: move on, and add another")
            } else {
                format!("{count} keyframes: {play} plays them")
            });
        }
    }

    /// Where the viewer is, as a keyframe.
    fn keyframe(&self) -> Keyframe {
        let pose = &self.viewer.pose;
        let planet = self.scene.planet();
        let height = pose.position.length() - planet.recipe.radius;
        // Above the terrain, as paths are played, however coarse what is drawn is.
        let altitude = (height - planet.surface_height(pose.up())).max(CLEARANCE_M);
        let stand = if self.panel.is_level() { Stand::Height(height) } else { Stand::Altitude(altitude) };
        let (up, fov) = (pose.up(), self.viewer.lens.fov.to_degrees());
        Waypoint { time_s: 0.0, up, stand, ahead: pose.ahead, pitch: pose.pitch.to_degrees(), fov }.keyframe()
    }

    /// Plays the path, or stops.
    fn play(&mut self) {
        if self.playback.take().is_some() {
            return;
        }
        match self.panel.board.path(self.scene.planet().recipe.radius) {
            Ok(path) => {
                let playback = Playback::new(path, None);
                self.viewer.rest();
                self.playback = Some(playback.lit(self.viewer.pose.up(), self.choices.look.sun));
            }
            Err(error) => {
                let add = self.viewer.keys.of_command(Command::AddKeyframe);
                self.panel.say(format!("no path to play: {error}; {add} adds a keyframe"));
            }
        }
    }

    /// Does what is asked for with the path, other than what the host does.
    pub(super) fn follow_path_wish(&mut self, wish: &PathWish) {
        match wish {
            PathWish::Take(journey) => self.panel.board.take(self.scene.planet().journey(*journey)),
            PathWish::Visit(at) => {
                let Some(keyframe) = self.panel.board.keyframes().get(*at) else { return };
                let camera = self.scene.planet().camera_at(keyframe, self.viewer.lens.size);
                self.viewer.lens.fov = camera.fov;
                self.fly_to(Pose::of_camera(&camera));
            }
            PathWish::Save(_) | PathWish::Load(_) | PathWish::Film(_) => {}
        }
        self.touch();
    }

    /// The view of a film: with the sun where it stands as seen from the path's end, as `record` takes it.
    pub(super) fn film_view(&self) -> ViewLine {
        let mut view = self.view_line();
        if let Some(last) = self.panel.board.keyframes().last() {
            (view.at, view.stand) = ([last.latitude, last.longitude], last.stand);
            let sun = sun_seen_from(direction_at(last.latitude, last.longitude), self.choices.look.sun);
            view.daylight = Some(Daylight::Over(sun));
        }
        view
    }

    /// Who does something themselves has seen enough of the path; one that is reported goes on.
    pub(super) fn stop_playing(&mut self) {
        self.playback = self.playback.take().filter(Playback::is_reported);
    }

    fn edit(&mut self, request: EditRequest) {
        // A frozen selection takes in nothing.
        self.selection = Selection::Follows;
        if let Err(error) = self.scene.edit(request) {
            self.panel.say(error.to_string());
        }
        self.touch();
    }

    /// Does what the panel was asked for; its commands are done with those of the keys, and what the host is asked for by the window.
    pub(super) fn answer(&mut self, asked: &mut Asked) {
        if let Some(site) = asked.destination.take() {
            self.go_to(&site);
        }
        if let Some(manner) = asked.manner.take() {
            self.viewer.set_manner(manner);
        }
        if let Some(speed) = asked.speed.take() {
            self.viewer.set_speed(speed);
        }
        if let Some(degrees) = asked.fov.take() {
            self.viewer.lens.fov = degrees.to_radians();
            self.touch();
        }
        for revision in asked.revisions.drain(..) {
            self.revise(revision);
        }
    }

    /// Flies to a site, to look north from there.
    fn go_to(&mut self, site: &Site) {
        let planet = self.scene.planet();
        let (direction, radius) = (direction_at(site.at[0], site.at[1]), planet.recipe.radius);
        let usual = || self.viewer.altitude(&self.surface()).min(ARRIVAL * radius);
        let altitude = site.altitude_m.unwrap_or_else(usual);
        let position = planet.position_above(direction, altitude);
        let lens = self.viewer.lens;
        self.fly_to(match site.look {
            Some([heading, pitch]) => Pose::of_camera(&Camera::looking(position, heading, pitch, lens.fov, lens.size)),
            None => Pose::new(position, local_frame(position).y_axis, resting_pitch(altitude, radius)),
        });
    }

    fn fly_to(&mut self, pose: Pose) {
        self.stop_playing();
        self.viewer.fly_to(pose, &DrawnSurface::of_scene(&self.scene, self.choices.look.sea));
        self.touch();
    }

    /// Flies to a view, and looks as it does.
    pub(super) fn show_view(&mut self, view: &ViewLine) {
        let planet = self.scene.planet();
        let direction = direction_at(view.at[0], view.at[1]);
        let position = match view.stand {
            // The viewer is lifted above what is drawn there: the sea's floor, where the sea is left out.
            Stand::Height(metres) => direction * (planet.recipe.radius + metres),
            Stand::Altitude(metres) => planet.position_above(direction, metres),
        };
        self.viewer.lens.fov = view.fov.map_or(self.viewer.lens.fov, f64::to_radians);
        let lens = self.viewer.lens;
        let [heading, pitch] = view.look.unwrap_or_else(|| {
            [0.0, resting_pitch(planet.altitude_of(direction, view.stand), planet.recipe.radius).to_degrees()]
        });
        let tilt = planet.recipe.axial_tilt;
        let look = &mut self.choices.look;
        look.sun = match view.daylight {
            Some(Daylight::Over([azimuth, elevation])) => sun_over(direction, azimuth, elevation),
            Some(Daylight::Date(second)) => sun::direction(second as f64, tilt),
            None => look.sun,
        };
        if view.daylight.is_some() {
            self.choices.date = view.date();
        }
        match view.exposure {
            Some(Exposure::Auto) => (look.exposure, look.metering) = (1.0, Some(0.0)),
            Some(Exposure::Fixed(factor)) => (look.exposure, look.metering) = (factor, None),
            None => {}
        }
        look.mode = view.mode.unwrap_or(Mode::Shaded);
        look.tone = view.tone.unwrap_or(Tone::Neutral);
        (look.clouds, look.sea, look.air, look.shadows) = (!view.clear_sky, !view.no_sea, !view.no_air, !view.no_shadows);
        self.choices.geomorphs = !view.no_geomorphs;
        self.choices.orientation = view.orientation;
        self.choices.tolerance = view.error.unwrap_or(self.choices.tolerance);
        self.fly_to(Pose::of_camera(&Camera::looking(position, heading, pitch, lens.fov, lens.size)));
    }

    /// Chooses everything as it is at first.
    pub(super) fn reset(&mut self) {
        let Settings { speed, geomorphs, .. } = Settings::default();
        self.viewer.set_speed(speed);
        let look = Look { mode: self.choices.look.mode, ..Look::daylight(self.choices.look.sun) };
        self.choices = Choices {
            look: Look { metering: Some(0.0), ..look },
            date: None,
            tolerance: USUAL_TOLERANCE,
            geomorphs,
            orientation: false,
            scale: self.choices.budget,
            ..self.choices
        };
        self.follow_scale();
        self.touch();
    }
}
