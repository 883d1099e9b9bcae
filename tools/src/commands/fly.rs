//! `terrane fly`: the planet in a window.

use super::drawing::DrawOptions;
use super::output::{check_output, Output};
use super::paths::load_path;
use super::planets::{planet_file, FILE};
use super::viewing::{report_messages, CameraOptions, Exposure};
use super::views::{check_planet, given, note_planet, HELP as HELP_VIEW, VALUE};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, Context as _};
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::time::Duration;
use terrane::app::{fly, Clipboard, FlyFrame, FlyOptions, Keys, Scale};
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::planet::Planet;
use terrane_planet::store::PlanetFile;

/// The planet unless told otherwise.
const USUAL: &str = "terra";

/// How long the viewer stands at the end of a path whose frames are reported.
const STANDS: Duration = Duration::from_secs(5);

/// Fly over a planet in a window.
///
/// A recipe needs no bake: its patches are built as they are seen, and kept in a file in the user's cache folder.
#[derive(clap::Args)]
#[command(after_help = format!("Keys and mouse:\n{}", Keys::default().help()))]
pub(crate) struct Fly {
    /// Planet file; or a recipe: a TOML file, or the name of one that comes with the command [default: that of --view, or terra].
    #[arg(value_name = FILE)]
    file: Option<PathBuf>,
    #[arg(long, value_name = VALUE, value_parser = given, help = HELP_VIEW)]
    view: Option<ViewLine>,
    #[command(flatten)]
    camera: CameraOptions,
    /// Pixels drawn along a side for each of the window's: always so many, or, with `auto`, as many as keep to `--frame-ms` while the
    /// viewer moves, and all of them once they stand still.
    #[arg(long, value_name = "auto|0.25..1", default_value = "auto", value_parser = scale)]
    scale: Automatic,
    /// Milliseconds that a moving frame may take before fewer pixels are drawn; 80 on software renderers unless told otherwise, and no
    /// limit on others.
    #[arg(long, value_name = "MS", value_parser = positive)]
    frame_ms: Option<f64>,
    /// Most frames a second; as many as the screen shows unless told otherwise.
    #[arg(long, value_name = "FPS", value_parser = positive)]
    max_fps: Option<f64>,
    /// Play a path first: a JSON file as `bench` takes it, or `descent`, `flyover`, `ground` or `plunge`.
    #[arg(long, value_name = "PATH.json|NAME")]
    path: Option<PathBuf>,
    /// With `--path`: stand still at its end for five seconds, close the window, and write what every frame cost into this JSON file.
    #[arg(long, value_name = "OUT", requires = "path")]
    report: Option<PathBuf>,
    /// Print which key does what, as the file `terrane/keys.toml` in the user's folder of settings can say it, and leave.
    #[arg(long)]
    keys: bool,
    #[command(flatten)]
    draw: DrawOptions,
    /// Folder for the pictures that P and F12 save.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    screenshots: PathBuf,
}

/// A scale as it is given: a number, or none for `auto`.
#[derive(Clone, Copy, Debug)]
struct Automatic(Option<f64>);

fn scale(text: &str) -> anyhow::Result<Automatic> {
    match text.parse::<f64>() {
        _ if text == "auto" => Ok(Automatic(None)),
        Ok(scale) if (0.25..=1.0).contains(&scale) => Ok(Automatic(Some(scale))),
        _ => bail!("'{text}' is neither 'auto' nor a number from 0.25 to 1"),
    }
}

fn positive(text: &str) -> anyhow::Result<f64> {
    match text.parse::<f64>() {
        Ok(number) if (0.1..=1e6).contains(&number) => Ok(number),
        _ => bail!("'{text}' is not a number from 0.1 to 1e6"),
    }
}

impl Run for Fly {
    fn run(mut self) -> anyhow::Result<Outcome> {
        let keys = keys()?;
        if self.keys {
            print!("{}", keys.to_toml());
            return Ok(Outcome::Done);
        }
        if let Some(line) = &self.view {
            self.camera.take(line);
            self.draw.take(line);
        }
        check_output("--screenshots", &self.screenshots, Output::Folder)?;
        let seen = self.view.as_ref().filter(|line| line.planet.is_some());
        let given = self.file.as_deref().or(if seen.is_none() { Some(Path::new(USUAL)) } else { None });
        let place = planet_file(given, seen)?;
        let planet = Planet::from_header(PlanetFile::open(place.path())?.header())?;
        self.view.iter().for_each(|line| check_planet(line, &planet));
        let camera = self.camera.camera(&planet)?;
        let mut view = self.camera.line(&planet)?;
        note_planet(&mut view, &planet);
        self.draw.note(&mut view, Exposure::Auto);
        let folder = self.screenshots;
        let path = self.path.as_deref().map(load_path).transpose()?;
        let (report, ended) = fly(FlyOptions {
            file: place.path().to_owned(),
            scale: self.scale.0.map(Scale::Fixed).or(self.frame_ms.map(Scale::Within)),
            most_fps: self.max_fps,
            keys,
            path,
            stand: self.report.as_ref().map(|_| STANDS),
            context: self.draw.gpu.options(),
            camera,
            scene: self.draw.patches.options()?,
            look: self.draw.look.look(&planet.recipe, self.camera.site(), Exposure::Auto),
            tolerance: self.camera.error(),
            geomorphs: self.draw.mesh.geomorphs(),
            orientation: self.draw.mesh.orientation(),
            view,
            save: Box::new(move |size, pixels, view| {
                save(&folder, size, pixels, view).map_err(|error| format!("not saved: {error:#}"))
            }),
            clipboard: Box::new(SystemClipboard::default()),
        });
        let reported = report_messages(&report.messages);
        ended?;
        reported?;
        if let Some(out) = &self.report {
            write_frames(out, &report.rows)?;
        }
        println!("{} frames in {:.1} s", report.frames, report.seconds);
        Ok(Outcome::Done)
    }
}

/// The usual keys, but for what the user's file says otherwise.
fn keys() -> anyhow::Result<Keys> {
    let folders = directories::ProjectDirs::from("", "", "terrane");
    let Some(file) = folders.map(|folders| folders.config_dir().join("keys.toml")).filter(|file| file.exists()) else {
        return Ok(Keys::default());
    };
    let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read the keys {}", file.display()))?;
    Keys::from_toml(&text).with_context(|| format!("{}", file.display()))
}

/// Writes what every frame cost.
fn write_frames(out: &Path, frames: &[FlyFrame]) -> anyhow::Result<()> {
    let row = |f: &FlyFrame| {
        json!({
            "time_s": f.time_s, "interval_ms": f.interval_ms, "cpu_ms": f.cpu_ms, "moving": f.moving, "scale": f.density,
            "patches": f.patches, "pending": f.pending, "allocations": f.allocations,
        })
    };
    let text = serde_json::to_string_pretty(&frames.iter().map(row).collect::<Value>())?;
    pictures::write_whole(out, text.as_bytes()).with_context(|| format!("cannot write the frames {}", out.display()))
}

/// The system's clipboard, opened when it is first wanted. It keeps what it was given until the window is closed, or a clipboard manager
/// beyond that.
#[derive(Default)]
struct SystemClipboard(Option<arboard::Clipboard>);

impl SystemClipboard {
    fn open(&mut self) -> Option<&mut arboard::Clipboard> {
        if self.0.is_none() {
            self.0 = arboard::Clipboard::new().inspect_err(|error| tracing::info!(%error, "no clipboard")).ok();
        }
        self.0.as_mut()
    }
}

impl Clipboard for SystemClipboard {
    fn copy(&mut self, text: &str) -> String {
        println!("{text}");
        match self.open().map(|clipboard| clipboard.set_text(text)) {
            Some(Ok(())) => "copied, and in the terminal".to_owned(),
            Some(Err(error)) => format!("it is in the terminal; the clipboard refused it: {error}"),
            None => "it is in the terminal; there is no clipboard".to_owned(),
        }
    }

    fn paste(&mut self) -> Option<String> {
        self.open()?.get_text().ok()
    }
}

/// Saves a picture under the first number that is free.
fn save(folder: &Path, size: [u32; 2], pixels: &[u8], view: &ViewLine) -> anyhow::Result<String> {
    let mut paths = (1u32..).map(|number| folder.join(format!("terrane-{number}.png")));
    let path = paths.find(|path| !path.exists()).unwrap_or_else(|| folder.join("terrane.png"));
    pictures::write_png(&path, size, pixels, Some(view))?;
    Ok(format!("saved {}", path.display()))
}
