//! What the window asks of the command: pictures as files, the clipboard, remembered views, other planets, settings.

use super::super::drawing::DrawOptions;
use super::super::pictures;
use super::super::planets::{planet_file, PlanetPlace};
use super::super::viewing::{CameraOptions, Exposure};
use super::super::views::{check_planet, given, note_planet};
use super::bookmarks::Shelf;
use super::filming::Filming;
use super::saved_paths::SavedPaths;
use super::settings;
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use terrane::app::{Bookmark, Host, Opened, Picture, Settings};
use terrane_planet::draw::camera_path::Route;
use terrane_planet::draw::view_line::{ViewLine, SCHEME};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;
use terrane_planet::store::PlanetFile;

/// The command around a window.
pub(super) struct CommandHost {
    /// Where pictures are saved.
    pub(super) screenshots: PathBuf,
    /// How planets are drawn, as the command line says.
    pub(super) draw: DrawOptions,
    pub(super) camera: CameraOptions,
    /// The files of all planets that were open: a folder of their own goes with them.
    pub(super) places: Vec<PlanetPlace>,
    pub(super) shelf: Option<Shelf>,
    /// Paths, beside the pictures.
    pub(super) paths: SavedPaths,
    pub(super) filming: Option<Filming>,
    /// Opened when it is first wanted. It keeps what it was given until the window is closed, or a clipboard manager beyond that.
    pub(super) clipboard: Option<arboard::Clipboard>,
}

impl CommandHost {
    fn open_clipboard(&mut self) -> Option<&mut arboard::Clipboard> {
        if self.clipboard.is_none() {
            self.clipboard = arboard::Clipboard::new().inspect_err(|error| tracing::info!(%error, "no clipboard")).ok();
        }
        self.clipboard.as_mut()
    }

    /// Finds a planet, and where to begin over it: as a view says, or as the command does.
    pub(super) fn find(&mut self, what: Option<&Path>, view: Option<&ViewLine>) -> anyhow::Result<(Opened, Planet)> {
        let (mut draw, mut camera) = (self.draw.clone(), self.camera.clone());
        if let Some(line) = view {
            camera.take(line);
            draw.take(line);
        }
        let place = planet_file(what, view)?;
        let planet = Planet::from_header(PlanetFile::open(place.path())?.header())?;
        let mut line = camera.line(&planet)?;
        note_planet(&mut line, &planet);
        draw.note(&mut line, Exposure::Auto);
        let opened = Opened {
            name: what.map_or_else(|| planet.recipe.name.to_lowercase(), lasting_name),
            file: place.path().to_owned(),
            published: draw.patches.published(&place),
            camera: camera.camera(&planet)?,
            look: draw.look.look(&planet.recipe, camera.site(&planet.recipe)?, Exposure::Auto),
            view: line,
        };
        view.iter().for_each(|line| check_planet(line, &planet));
        self.places.push(place);
        Ok((opened, planet))
    }
}

impl Host for CommandHost {
    fn save(&mut self, picture: &Picture, view: &ViewLine) -> Result<String, String> {
        save(&self.screenshots, picture, view).map_err(|error| format!("not saved: {error:#}"))
    }

    fn copy(&mut self, text: &str) -> String {
        println!("{text}");
        match self.open_clipboard().map(|clipboard| clipboard.set_text(text)) {
            Some(Ok(())) => "copied, and in the terminal".to_owned(),
            Some(Err(error)) => format!("it is in the terminal; the clipboard refused it: {error}"),
            None => "it is in the terminal; there is no clipboard".to_owned(),
        }
    }

    fn paste(&mut self) -> Option<String> {
        self.open_clipboard()?.get_text().ok()
    }

    fn bookmarks(&mut self) -> Vec<Bookmark> {
        self.shelf.as_ref().map_or(Vec::new(), Shelf::all)
    }

    fn add_bookmark(&mut self, bookmark: &Bookmark) -> Result<(), String> {
        let shelf = self.shelf.as_ref().ok_or("views cannot be remembered: there is no home folder")?;
        shelf.add(bookmark).map_err(|error| format!("not remembered: {error:#}"))
    }

    fn remove_bookmark(&mut self, name: &str) -> Result<(), String> {
        let shelf = self.shelf.as_ref().ok_or("there is no home folder")?;
        shelf.remove(name).map_err(|error| format!("not forgotten: {error:#}"))
    }

    fn save_path(&mut self, name: &str, route: &Route) -> Result<String, String> {
        let saved = self.paths.save(name, route).map_err(|error| format!("not saved: {error:#}"))?;
        Ok(format!("saved {}", saved.display()))
    }

    fn load_path(&mut self, name: &str) -> Result<Route, String> {
        self.paths.load(name).map_err(|error| format!("{error:#}"))
    }

    fn film(&mut self, planet: &Path, name: &str, route: &Route, view: &ViewLine) -> Result<String, String> {
        if self.filming.is_some() {
            return Err("a film is being drawn already: wait for it".to_owned());
        }
        let path = self.paths.save(name, route).map_err(|error| format!("no film: {error:#}"))?;
        let film = Filming::begin(planet, &path, view, self.draw.gpu.given()).map_err(|error| format!("no film: {error:#}"))?;
        let what = if film.out.is_dir() { "there is no ffmpeg: single pictures are drawn into" } else { "a film is drawn:" };
        let said = format!("{what} {}", film.out.display());
        self.filming = Some(film);
        Ok(said)
    }

    fn expects_news(&self) -> bool {
        self.filming.is_some()
    }

    fn news(&mut self) -> Option<String> {
        let said = self.filming.as_mut()?.news()?;
        self.filming = None;
        Some(said)
    }

    fn planets(&self) -> Vec<String> {
        shipped::names().map(str::to_owned).collect()
    }

    fn view(&mut self, what: &str) -> Result<Option<ViewLine>, String> {
        let is_picture = Path::new(what).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        if what.trim_start().starts_with(SCHEME) || is_picture {
            return given(what).map(Some);
        }
        Ok(None)
    }

    fn open(&mut self, what: &str) -> Result<Opened, String> {
        // Where the command began is over another planet.
        self.camera = self.camera.of_whole_planet();
        self.find(Some(Path::new(what)), None).map(|(opened, _)| opened).map_err(|error| format!("{error:#}"))
    }

    fn keep(&mut self, kept: &Settings) -> Result<(), String> {
        settings::keep(kept).map_err(|error| format!("the settings are not kept: {error:#}"))
    }
}

/// Saves a picture under the first number that is free.
fn save(folder: &Path, picture: &Picture, view: &ViewLine) -> anyhow::Result<String> {
    let mut paths = (1u32..).map(|number| folder.join(format!("terrane-{number}.png")));
    let path = paths.find(|path| !path.exists()).unwrap_or_else(|| folder.join("terrane.png"));
    pictures::write_png(&path, picture.size, &picture.rgba, Some(view)).context("a picture of the window")?;
    Ok(format!("saved {}", path.display()))
}

/// What a planet can be opened by from any folder.
fn lasting_name(what: &Path) -> String {
    let file = Some(what).filter(|what| what.is_file()).and_then(|what| what.canonicalize().ok());
    file.as_deref().unwrap_or(what).display().to_string()
}
