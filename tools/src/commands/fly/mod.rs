//! `terrane fly`: the planet in a window.

mod bookmarks;
mod filming;
mod host;
mod saved_paths;
mod settings;

use super::drawing::DrawOptions;
use super::output::{check_output, Output};
use super::paths::{self, GivenPath};
use super::planets::FILE;
use super::viewing::{report_messages, CameraOptions};
use super::views::{given, HELP as HELP_VIEW, VALUE};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, Context as _};
use bookmarks::Shelf;
use host::CommandHost;
use saved_paths::SavedPaths;
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::time::Duration;
use terrane::app::{fly, FlyFrame, FlyOptions, Keys, Scale, Settings};
#[cfg(feature = "hot-reload")]
use terrane::hot_reload::ShaderWatch;
use terrane::scene::SceneOptions;
use terrane_planet::draw::layout::Tone;
use terrane_planet::draw::view_line::{Daylight, Stand, ViewLine};

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
    ///
    /// As in the last window, if nothing is said.
    #[arg(long, value_name = "auto|0.25..1", value_parser = scale)]
    scale: Option<Automatic>,
    /// Milliseconds that a moving frame may take before fewer pixels are drawn; 80 on software renderers unless told otherwise, and no
    /// limit on others.
    #[arg(long, value_name = "MS", value_parser = positive)]
    frame_ms: Option<f64>,
    /// Most frames a second; as many as the screen shows unless told otherwise.
    #[arg(long, value_name = "FPS", value_parser = positive)]
    max_fps: Option<f64>,
    /// Play a path first, as `terrane bench` takes it: a JSON file, or descent, coast, tour and others by name.
    #[arg(long, value_name = paths::VALUE)]
    path: Option<PathBuf>,
    /// With `--path`: stand still at its end for five seconds, close the window, and write what every frame cost into this JSON file.
    #[arg(long, value_name = "OUT", requires = "path")]
    report: Option<PathBuf>,
    /// Print which key does what, as the file `terrane/keys.toml` in the user's folder of settings can say it, and leave.
    #[arg(long)]
    keys: bool,
    /// Draw with the shaders in this folder, as they are edited; mistakes are told, and the shaders before stay.
    #[cfg(feature = "hot-reload")]
    #[arg(long, value_name = "FOLDER")]
    shaders: Option<PathBuf>,
    #[command(flatten)]
    draw: DrawOptions,
    /// Folder for what the window saves: pictures, paths and films.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    screenshots: PathBuf,
}

/// Pixels that can be drawn along a side for each of the window's.
const SCALES: std::ops::RangeInclusive<f64> = 0.25..=1.0;

/// A scale as it is given: a number, or none for `auto`.
#[derive(Clone, Copy, Debug)]
struct Automatic(Option<f64>);

fn scale(text: &str) -> anyhow::Result<Automatic> {
    match text.parse::<f64>() {
        _ if text == "auto" => Ok(Automatic(None)),
        Ok(scale) if SCALES.contains(&scale) => Ok(Automatic(Some(scale))),
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
        let keys = settings::keys()?;
        if self.keys {
            print!("{}", keys.to_toml());
            return Ok(Outcome::Done);
        }
        check_output("--screenshots", &self.screenshots, Output::Folder)?;
        let mut settings = settings::load();
        self.choose(&settings);
        let mut host = CommandHost {
            screenshots: self.screenshots.clone(),
            draw: self.draw.clone(),
            camera: self.camera.clone(),
            places: Vec::new(),
            shelf: Shelf::of_user(),
            paths: SavedPaths::of(&self.screenshots),
            filming: None,
            clipboard: None,
        };
        if let Some(line) = &self.view {
            self.camera.take(line);
            self.draw.take(line);
        }
        let seen = self.view.as_ref().filter(|line| line.planet.is_some());
        let given = self.file.as_deref().or(if seen.is_none() { Some(Path::new(USUAL)) } else { None });
        let path = self.path.as_deref().map(GivenPath::read).transpose()?;
        let (opened, planet) = host.find(given, self.view.as_ref())?;
        settings.note_opened(&opened.name);
        let path = path.map(|path| path.over(&planet)).transpose()?;
        let (report, ended) = fly(FlyOptions {
            file: opened.file,
            scale: self.scale(&settings),
            most_fps: self.max_fps,
            keys,
            path,
            stand: self.report.as_ref().map(|_| STANDS),
            context: self.draw.gpu.options(),
            camera: opened.camera,
            scene: SceneOptions { published: opened.published, ..self.draw.patches.options()? },
            look: opened.look,
            tolerance: self.camera.error(),
            geomorphs: self.draw.mesh.geomorphs(),
            orientation: self.draw.mesh.orientation(),
            view: opened.view,
            settings,
            #[cfg(feature = "hot-reload")]
            shaders: self
                .shaders
                .as_deref()
                .map(ShaderWatch::new)
                .transpose()
                .map_err(|problem| anyhow::anyhow!("--shaders: {problem}"))?,
            host: Box::new(host),
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

impl Fly {
    /// Takes from the settings what was not given. A view says all there is to say.
    fn choose(&mut self, settings: &Settings) {
        if self.view.is_some() {
            return;
        }
        let mut usual = ViewLine::from_site([0.0; 2], Stand::Height(0.0));
        usual.no_geomorphs = !settings.geomorphs;
        usual.tone = settings.tone.as_ref().and_then(|name| Tone::ALL.into_iter().find(|tone| tone.name() == name));
        usual.daylight = settings.date.map(Daylight::Date);
        self.draw.take(&usual);
        self.camera.choose_error(settings.tolerance);
    }

    /// How many pixels are drawn: as the options say, else as the settings do.
    fn scale(&self, settings: &Settings) -> Option<Scale> {
        let kept = || settings.scale.filter(|scale| SCALES.contains(scale)).map(Scale::Fixed);
        match (self.scale, self.frame_ms) {
            (Some(Automatic(Some(scale))), _) => Some(Scale::Fixed(scale)),
            (_, Some(ms)) => Some(Scale::Within(ms)),
            (Some(Automatic(None)), None) => None,
            (None, None) => kept(),
        }
    }
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
