//! `terrane record`: a camera path as numbered pictures or as a film.

use super::building::{stop_on_signals, Report};
use super::drawing::DrawOptions;
use super::film::{container, Film};
use super::paths::{self, GivenPath};
use super::planets::{planet_file, FILE, WITH_VIEW};
use super::still::StillArguments;
use super::strip::Strip;
use super::viewing::{check_tolerance, picture_size};
use super::views::{check_planet, given, VALUE};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, ensure, Context as _};
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;
use terrane::stills::{PixelFormat, Studio};
use terrane_planet::draw::camera_path::Route;
use terrane_planet::draw::view_line::ViewLine;

/// Picture size and tolerance in pixels unless told otherwise.
const DEFAULT_SIZE: [u32; 2] = [1920, 1080];
const DEFAULT_ERROR: f64 = 1.0;

/// What the pictures in a folder were recorded with.
const NOTES: &str = "record.json";

/// Most frames of one recording: six digits.
const MOST_FRAMES: f64 = 999_999.0;

/// Record a camera path: every frame complete, at equal steps of time.
///
/// A path is a JSON list of keyframes {time_s, latitude, longitude, altitude_m, heading, pitch, fov}: see `terrane bench`. A folder gets
/// one PNG a frame; frames that are there already are kept, so an interrupted recording goes on where it stopped. A film is made by
/// ffmpeg, which must be installed, and starts anew each time.
#[derive(clap::Args)]
pub(crate) struct Record {
    #[arg(value_name = FILE, help = WITH_VIEW)]
    file: Option<PathBuf>,
    #[arg(long, value_name = paths::VALUE, help = paths::HELP)]
    path: PathBuf,
    /// Frames a second, 0.1 to 240.
    #[arg(long, value_name = "F", default_value_t = 30.0)]
    fps: f64,
    /// Only so many frames, from the first to the last at equal steps of time, side by side in one picture.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=64), conflicts_with = "fps")]
    strip: Option<u32>,
    /// Folder for 000001.png, 000002.png and so on; or a film, x.mp4 (H.264) or x.webm (VP9); or with `--strip` a picture, x.png or x.jpg.
    #[arg(long, value_name = "FOLDER|x.mp4|x.webm|x.png|x.jpg")]
    out: PathBuf,
    /// Take size, tolerance, light and look from a view; from where it is seen the path says.
    ///
    /// A view is text such as terrane:1/at=46,8/altitude=900/sun=90,10, or a PNG that terrane drew. Options beside it go first.
    #[arg(long, value_name = VALUE, value_parser = given)]
    view: Option<ViewLine>,
    /// Picture size in pixels, sides from 16 to 16384; even for films [default: 1920x1080].
    #[arg(long, value_name = "WxH", value_parser = picture_size)]
    size: Option<[u32; 2]>,
    /// Largest error of the mesh in pixels, 0.05 to 64 [default: 1].
    #[arg(long, value_name = "PX")]
    error: Option<f64>,
    #[command(flatten)]
    still: StillArguments,
    #[command(flatten)]
    draw: DrawOptions,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What became of a recording.
#[derive(Default)]
struct Tally {
    frames: usize,
    drawn: usize,
    kept: usize,
    interrupted: bool,
}

impl Run for Record {
    fn run(mut self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        if let Some(line) = &self.view {
            self.size = self.size.or(line.size);
            self.error = self.error.or(line.error);
            self.still.take(line);
            self.draw.take(line);
        }
        let (size, error) = (self.size(), self.error());
        check_tolerance(error)?;
        ensure!((0.1..=240.0).contains(&self.fps), "--fps: {} is not within 0.1 and 240 frames a second", self.fps);
        let path = GivenPath::read(&self.path)?;
        let stop = stop_on_signals()?;
        let mut film = self.film()?;
        let place = planet_file(self.file.as_deref(), self.view.as_ref())?;
        let (context, mut scene) = self.draw.open(&place)?;
        self.view.iter().for_each(|line| check_planet(line, scene.planet()));
        let (route, path) = (path.route(scene.planet()), path.over(scene.planet())?);
        let (first, last) = path.span();
        let frames = self.strip.map_or(((last - first) * self.fps).floor() + 1.0, f64::from);
        let step_s = self.strip.map_or(1.0 / self.fps, |count| (last - first) / f64::from(count - 1));
        ensure!(frames <= MOST_FRAMES, "--fps: {frames} frames, expected at most {MOST_FRAMES}; choose fewer a second");
        if container(&self.out).is_none() && self.strip.is_none() {
            self.check_notes(&self.out.join(NOTES), &route)?;
        }
        let look = self.draw.look_along(&scene.planet().recipe, &path);
        let mut studio = Studio::new(&context, size, self.still.options(PixelFormat::Eight))?;
        let report = Report::counting(&self.out.display().to_string(), "frames");
        let mut tally = Tally { frames: frames as usize, ..Tally::default() };
        for number in 1..=tally.frames {
            if stop.load(Ordering::Relaxed) {
                tally.interrupted = true;
                break;
            }
            if film.has(number) {
                tally.kept += 1;
            } else {
                let waypoint = path.at(first + (number - 1) as f64 * step_s);
                let look = look.at(waypoint.time_s);
                scene.set_sun(look.sun);
                let planet = scene.planet();
                let view = self.draw.view(planet.camera_on(&waypoint, size), planet, error);
                let cut = scene.settle(&view)?;
                film.add(number, &studio.draw(&scene, &view, &cut, &look, &|_, _| ())?)?;
                tally.drawn += 1;
            }
            report.step(number, tally.frames, begun.elapsed());
        }
        report.finish();
        film.finish()?;
        self.print(&tally, begun.elapsed().as_secs_f64(), &context.device_info().name);
        self.draw.gpu.report_messages(&context)?;
        Ok(if tally.interrupted { Outcome::Interrupted } else { Outcome::Done })
    }
}

impl Record {
    fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(DEFAULT_SIZE)
    }

    fn error(&self) -> f64 {
        self.error.unwrap_or(DEFAULT_ERROR)
    }

    /// Where the frames go. Fails before anything is drawn if they cannot.
    fn film(&self) -> anyhow::Result<Film> {
        if let Some(count) = self.strip {
            return Ok(Film::Strip(Strip::new(&self.out, self.size(), count)?));
        }
        if container(&self.out).is_some() {
            ensure!(!self.still.transparent_sky, "--transparent-sky: films have no alpha; record a folder of pictures");
            return Film::encoder(&self.out, self.size(), self.fps);
        }
        if let Some(extension) = self.out.extension() {
            let named = extension.to_string_lossy();
            ensure!(self.out.is_dir(), "--out: a .{named} is neither a film (.mp4, .webm) nor a folder that exists");
        }
        Film::folder(&self.out)
    }

    /// Refuses to go on with pictures that were recorded otherwise.
    fn check_notes(&self, notes: &Path, route: &Route) -> anyhow::Result<()> {
        let seen = self.view.as_ref().and_then(|line| line.planet.as_ref());
        let ours = json!({
            "planet": self.file.as_deref().or(seen.map(Path::new)), "path": route.to_json(), "fps": self.fps, "size": self.size(), "tolerance_px": self.error(),
            "still": format!("{:?}", self.still.options(PixelFormat::Eight)), "mesh": format!("{:?}", self.draw.mesh), "look": format!("{:?}", self.draw.look),
        });
        if !notes.exists() {
            let text = serde_json::to_string_pretty(&ours)? + "\n";
            return pictures::write_whole(notes, text.as_bytes()).with_context(|| format!("cannot write {}", notes.display()));
        }
        let text = std::fs::read_to_string(notes).with_context(|| format!("cannot read {}", notes.display()))?;
        let theirs: Value = serde_json::from_str(&text).with_context(|| format!("{} is damaged; delete it", notes.display()))?;
        for (key, value) in ours.as_object().into_iter().flatten() {
            if theirs.get(key) != Some(value) {
                bail!(
                    "{}: the frames there were recorded with another {key} ({}, now {value}); choose another folder, or empty this one",
                    notes.display(),
                    theirs.get(key).unwrap_or(&Value::Null)
                );
            }
        }
        Ok(())
    }

    fn print(&self, tally: &Tally, seconds: f64, device: &str) {
        let Tally { frames, drawn, kept, interrupted } = *tally;
        if self.json {
            let summary = json!({
                "out": self.out, "frames": frames, "drawn": drawn, "kept": kept, "interrupted": interrupted, "fps": self.fps,
                "size": self.size(), "ssaa": self.still.ssaa(), "seconds": seconds, "device": device,
            });
            println!("{summary}");
            return;
        }
        println!("{}: {drawn} of {frames} frames drawn, {kept} there before, {seconds:.1} s", self.out.display());
        if interrupted {
            match container(&self.out) {
                _ if self.strip.is_some() => println!("interrupted: the frames that are missing are white"),
                Some(_) => println!("interrupted: the film ends after {drawn} frames"),
                None => println!("interrupted: the same command goes on from here"),
            }
        }
    }
}
