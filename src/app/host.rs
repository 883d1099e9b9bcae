//! What a window asks of the program around it: files, the clipboard, planets.

use crate::frame::Look;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use terrane_planet::draw::camera_path::Route;
use terrane_planet::draw::view::Camera;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::published::PublishedPlanet;

/// A picture of 8 bits a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Red, green, blue and alpha, row by row from the top.
    pub rgba: Vec<u8>,
}

/// A view that the user remembers by a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Bookmark {
    /// Its name, as the user gave it.
    pub name: String,
    /// The view.
    pub view: ViewLine,
    /// How it looks, small.
    pub thumbnail: Picture,
}

/// A planet to fly over, and where to begin.
#[derive(Clone, Debug)]
pub struct Opened {
    /// What to call it among those opened lately.
    pub name: String,
    /// Planet file.
    pub file: PathBuf,
    /// Where what the file lacks is published, if it is to be fetched.
    pub published: Option<Arc<PublishedPlanet>>,
    /// Where to begin; its size is not looked at.
    pub camera: Camera,
    /// How it looks there.
    pub look: Look,
    /// What is known of the view beside camera and look: planet, spacing and so on.
    pub view: ViewLine,
}

/// What the user chose in a window, to be chosen again in the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Whether the panel is shown.
    pub panel: bool,
    /// Factor of the speed of free flight and of walking.
    pub speed: f64,
    /// Largest error of the mesh in pixels; the usual one if none.
    pub tolerance: Option<f64>,
    /// Whether vertices slide into their positions.
    pub geomorphs: bool,
    /// Pixels drawn along a side for each of the window's, from 0.25 to 1; as many as are quick enough if none.
    pub scale: Option<f64>,
    /// Name of the tone curve; the usual one if none.
    pub tone: Option<String>,
    /// Seconds since 1970 of the time by which the sun stands; where it usually does if none.
    pub date: Option<i64>,
    /// Planets opened lately, the latest first.
    pub recent: Vec<String>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            panel: false,
            speed: 1.0,
            tolerance: None,
            geomorphs: true,
            scale: None,
            tone: None,
            date: None,
            recent: Vec::new(),
        }
    }
}

/// Most planets that are remembered as opened lately.
const MOST_RECENT: usize = 8;

impl Settings {
    /// These, but for what was changed from one state of a window to a later one: options of a single run are not to be kept.
    pub fn with_changes(self, from: &Settings, to: &Settings) -> Settings {
        fn of<T: PartialEq + Clone>(kept: T, from: &T, to: &T) -> T {
            if from == to {
                kept
            } else {
                to.clone()
            }
        }
        Settings {
            panel: of(self.panel, &from.panel, &to.panel),
            speed: of(self.speed, &from.speed, &to.speed),
            tolerance: of(self.tolerance, &from.tolerance, &to.tolerance),
            geomorphs: of(self.geomorphs, &from.geomorphs, &to.geomorphs),
            scale: of(self.scale, &from.scale, &to.scale),
            tone: of(self.tone, &from.tone, &to.tone),
            date: of(self.date, &from.date, &to.date),
            recent: to.recent.clone(),
        }
    }

    /// Remembers a planet as the latest.
    pub fn note_opened(&mut self, name: &str) {
        self.recent.retain(|other| other != name);
        self.recent.insert(0, name.to_owned());
        self.recent.truncate(MOST_RECENT);
    }
}

/// What a window asks of the program around it. What goes wrong is said in words, and shown to the user.
pub trait Host {
    /// Saves a picture. Returns what to tell the user.
    ///
    /// # Errors
    /// Why it was not saved.
    fn save(&mut self, picture: &Picture, view: &ViewLine) -> Result<String, String>;

    /// Hands text to the user. Returns what to tell them of it.
    fn copy(&mut self, text: &str) -> String;

    /// What the user has copied.
    fn paste(&mut self) -> Option<String>;

    /// The views that the user remembers.
    fn bookmarks(&mut self) -> Vec<Bookmark>;

    /// Remembers a view. A name that is taken gets a number.
    ///
    /// # Errors
    /// Why it cannot be remembered.
    fn add_bookmark(&mut self, bookmark: &Bookmark) -> Result<(), String>;

    /// Forgets a view.
    ///
    /// # Errors
    /// Why it cannot be forgotten.
    fn remove_bookmark(&mut self, name: &str) -> Result<(), String>;

    /// Saves a camera path under a name, as JSON. Returns what to tell the user.
    ///
    /// # Errors
    /// Why it was not saved.
    fn save_path(&mut self, name: &str, route: &Route) -> Result<String, String>;

    /// Reads a camera path that has a name.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn load_path(&mut self, name: &str) -> Result<Route, String>;

    /// Begins to film a camera path over a planet file, as a view looks. Returns what to tell the user now; what becomes of it is
    /// [`Host::news`].
    ///
    /// # Errors
    /// Why it cannot begin.
    fn film(&mut self, planet: &Path, name: &str, route: &Route, view: &ViewLine) -> Result<String, String>;

    /// Whether something is under way that there will be news of.
    fn expects_news(&self) -> bool;

    /// What happened meanwhile that the user is to be told.
    fn news(&mut self) -> Option<String>;

    /// Names of planets that can always be opened.
    fn planets(&self) -> Vec<String>;

    /// The view that a text or a picture is. None if it names a planet.
    ///
    /// # Errors
    /// Why it is no view, though it looks like one.
    fn view(&mut self, what: &str) -> Result<Option<ViewLine>, String>;

    /// Finds a planet by name, recipe or file.
    ///
    /// # Errors
    /// Why there is none.
    fn open(&mut self, what: &str) -> Result<Opened, String>;

    /// Keeps settings for the next window.
    ///
    /// # Errors
    /// Why they cannot be kept.
    fn keep(&mut self, settings: &Settings) -> Result<(), String>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_changed_in_the_window_is_kept() {
        let kept = Settings { speed: 3.0, scale: Some(0.5), ..Settings::default() };
        // A run with another tolerance and scale, in which only the panel was opened.
        let begun = Settings { tolerance: Some(8.0), scale: Some(0.25), speed: 3.0, ..Settings::default() };
        let ended = Settings { panel: true, ..begun.clone() };
        assert_eq!(kept.clone().with_changes(&begun, &ended), Settings { panel: true, ..kept });
    }

    #[test]
    fn the_latest_planets_are_remembered_once_each() {
        let mut settings = Settings::default();
        for name in ["a", "b", "a", "c", "d", "e", "f", "g", "h", "i", "j"] {
            settings.note_opened(name);
        }
        assert_eq!(settings.recent, ["j", "i", "h", "g", "f", "e", "d", "c"]);
    }
}
