//! `bench --first-look`: what pictures cost whose patches are not there yet, what they cost again, and what a turn of the head finds.

mod report;
mod sights;

use super::{process, write_report, Bench};
use crate::commands::building::{Report, Threads};
use crate::commands::drawing::first_picture;
use crate::commands::planets::PlanetPlace;
use crate::commands::viewing::{check_tolerance, Exposure};
use anyhow::{ensure, Context as _};
use report::Row;
use sights::{sights, Sight};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::thread::sleep;
use std::time::{Duration, Instant};
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::measure::live::{LiveFaults, LiveFlight};
use terrane::scene::{Scene, SceneError, SceneOptions, Scope};
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::draw::view::View;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::store::slow::Delay;
use terrane_planet::store::PlanetFile;

/// Times that a picture is made so that its file holds everything: what is built faster than it can be written is not kept.
const MOST_FILLINGS: usize = 4;

/// Longest wait for what surrounds a view, and how long nothing more must be asked for.
const LONGEST_WAIT: Duration = Duration::from_secs(120);
const QUIET: Duration = Duration::from_millis(500);

/// Time between two looks at what has arrived meanwhile.
const PAUSE: Duration = Duration::from_millis(10);

/// By how many degrees the camera turns, on the spot.
const TURN: f64 = 90.0;

/// Frames before a turn, the first of which have tables and shaders to make, and after it until nothing is waited for any more.
const FRAMES_BEFORE: usize = 3;
const MOST_FRAMES: usize = 20_000;

/// What one picture took.
struct Picture {
    drawn: usize,
    resident: usize,
    built: u64,
    surveyed: u64,
    triangles: u32,
    usage: Usage,
    /// Seconds until a whole picture could be drawn, however coarse, and until nothing was missing.
    first_s: f64,
    settled_s: f64,
    /// Bytes of patches on the GPU, and of everything there.
    gpu_bytes: u64,
    allocated_bytes: u64,
}

/// What a turn on the spot found.
struct Turn {
    /// Seconds until the surroundings were there, and whether they ever were.
    surroundings_s: f64,
    surrounded: bool,
    resident: usize,
    built: u64,
    /// Faults of the first frame after the turn, and whether anything was missing in it.
    faults: LiveFaults,
    settled_at_once: bool,
    /// Seconds from the turn to the end of the first frame that lacked nothing; the check of the first frame is part of it, if that one
    /// lacked something.
    settled_s: f64,
    usage: Usage,
    gpu_bytes: u64,
    allocated_bytes: u64,
}

/// What the process used for a row.
#[derive(Clone, Copy)]
struct Usage {
    cpu_s: Option<f64>,
    /// Bytes of main memory at most, and at the beginning: the allocator holds on to some of the row before.
    peak_bytes: Option<u64>,
    bytes_before: Option<u64>,
}

/// The beginning of a row.
struct Started {
    at: Instant,
    cpu_s: Option<f64>,
    bytes: Option<u64>,
    peak_is_known: bool,
}

impl Started {
    fn now() -> Started {
        let (peak_is_known, bytes) = (process::forget_peak(), process::resident_bytes());
        Started { at: Instant::now(), cpu_s: process::cpu_seconds(), bytes, peak_is_known }
    }

    fn usage(&self) -> Usage {
        let cpu_s = process::cpu_seconds().zip(self.cpu_s).map(|(now, before)| now - before);
        Usage { cpu_s, peak_bytes: process::peak_bytes().filter(|_| self.peak_is_known), bytes_before: self.bytes }
    }
}

impl Bench {
    /// All views, each in a planet file of its own.
    pub(super) fn first_looks(&self) -> anyhow::Result<()> {
        check_tolerance(self.error)?;
        let on_demand = self.draw.patches.options()?.on_demand;
        let keeps = on_demand.is_some_and(|on_demand| on_demand.cache.is_some());
        ensure!(keeps, "--first-look builds patches and keeps them: leave out --stored-only and --cache 0");
        let folder = tempfile::Builder::new().prefix("terrane-").tempdir().context("cannot make a temporary folder")?;
        let faces = folder.path().join("faces.planet");
        let planet = bake_faces(&self.file, &faces)?;
        let sights = sights(&planet, self.at, self.look)?;
        let progress = Report::counting("first look", "views");
        let begun = Instant::now();
        let mut rows = Vec::new();
        for (number, sight) in sights.iter().enumerate() {
            let file = folder.path().join(format!("{number}.planet"));
            std::fs::copy(&faces, &file).with_context(|| format!("cannot write {}", file.display()))?;
            rows.extend(self.rows_of(sight, &file)?);
            std::fs::remove_file(&file).with_context(|| format!("cannot remove {}", file.display()))?;
            progress.step(number + 1, sights.len(), begun.elapsed());
        }
        progress.finish();
        let device = self.draw.gpu.context()?.device_info().clone();
        let [width, height] = self.size;
        println!("{} ({} {})", device.name, device.driver, device.driver_info);
        println!(
            "first looks at {} at {width}x{height}, {} px{}, commit {}\n",
            planet.recipe.name,
            self.error,
            self.draw.mesh.describe(),
            env!("TERRANE_COMMIT")
        );
        report::print(&rows);
        if let Some(out) = &self.json {
            let mut whole = self.setting(&device);
            whole["rows"] = rows.iter().map(Row::json).collect();
            write_report(out, &whole)?;
        }
        Ok(())
    }

    /// The rows of a view: from nothing, from the file, over a line if one is asked for, and the turn.
    fn rows_of<'a>(&self, sight: &'a Sight, file: &Path) -> anyhow::Result<Vec<Row<'a>>> {
        let nothing = self.picture(&sight.keyframe, file, None)?;
        let mut again = self.picture(&sight.keyframe, file, None)?;
        for _ in 2..MOST_FILLINGS {
            if again.built == 0 {
                break;
            }
            again = self.picture(&sight.keyframe, file, None)?;
        }
        let mut rows = vec![Row::Nothing(sight, nothing), Row::File(sight, again)];
        if let Some(delay) = self.source_delay {
            rows.push(Row::Line(sight, self.picture(&sight.keyframe, file, Some(delay))?));
        }
        rows.push(Row::Turn(sight, self.turn(&sight.keyframe, file)?));
        Ok(rows)
    }

    /// Makes a picture as `shot` does, and says what it took.
    fn picture(&self, keyframe: &Keyframe, file: &Path, delay: Option<Delay>) -> anyhow::Result<Picture> {
        let started = Started::now();
        let options = SceneOptions { scope: Scope::Still, delay, ..self.draw.patches.options()? };
        let (context, mut scene) = self.draw.open_with(file, options)?;
        let (view, look) = (self.view_of(keyframe, scene.planet()), self.look_at(keyframe, scene.planet()));
        scene.set_sun(look.sun);
        first_picture(&mut scene, &view)?;
        let first_s = started.at.elapsed().as_secs_f64();
        let cut = scene.settle(&view)?;
        let settled_s = started.at.elapsed().as_secs_f64();
        let mut headless = Headless::new(&context, self.size.into())?;
        let frame = headless.render(&scene, &view, &cut, &look)?;
        let tally = scene.tally();
        self.draw.gpu.report_messages(&context)?;
        Ok(Picture {
            drawn: frame.tables.patches.len(),
            resident: scene.resident_count(),
            built: tally.built,
            surveyed: tally.surveyed,
            triangles: frame.counters.wanted,
            usage: started.usage(),
            first_s,
            settled_s,
            gpu_bytes: scene.gpu_bytes().0,
            allocated_bytes: context.allocated_bytes(),
        })
    }

    /// Waits until a view and what surrounds it are there, turns, and says what is missing then.
    fn turn(&self, keyframe: &Keyframe, file: &Path) -> anyhow::Result<Turn> {
        let started = Started::now();
        let (context, mut scene) = self.draw.open_for(&PlanetPlace::of_file(file), Scope::Flight)?;
        let planet = scene.shared_planet();
        let look = self.look_at(keyframe, &planet);
        let turned = Keyframe { heading: keyframe.heading + TURN, ..*keyframe };
        let [before, after] = [keyframe, &turned].map(|keyframe| planet.camera_at(keyframe, self.size));
        let view = |camera| self.draw.view(camera, &planet, self.error);
        scene.set_sun(look.sun);
        scene.settle(&view(before))?;
        let settled = Instant::now();
        let surrounded = surround(&mut scene, &view(before))?;
        let surroundings_s = settled.elapsed().as_secs_f64();
        let mut headless = Headless::new(&context, self.size.into())?;
        // As in a window, slow frames take in more patches.
        let mut step_s = 0.0;
        for _ in 0..FRAMES_BEFORE {
            let (frame, ..) = LiveFlight::new(&context, &mut scene, &mut headless, step_s).frame(before, &view, &look)?;
            step_s = 1e-3 * frame.frame_ms;
        }
        let mut flight = LiveFlight::new(&context, &mut scene, &mut headless, step_s);
        let turned_at = Instant::now();
        let (first, seen, cut) = flight.frame(after, &view, &look)?;
        let mut settled_s = turned_at.elapsed().as_secs_f64();
        let faults = flight.faults(&seen, &cut, &look)?;
        let mut last = first;
        for _ in 0..MOST_FRAMES {
            if last.settled {
                break;
            }
            last = flight.frame(after, &view, &look)?.0;
            settled_s = turned_at.elapsed().as_secs_f64();
        }
        self.draw.gpu.report_messages(&context)?;
        Ok(Turn {
            surroundings_s,
            surrounded,
            resident: last.resident,
            built: scene.tally().built,
            faults,
            settled_at_once: first.settled,
            settled_s,
            usage: started.usage(),
            gpu_bytes: last.gpu_bytes,
            allocated_bytes: last.allocated_bytes,
        })
    }

    fn view_of(&self, keyframe: &Keyframe, planet: &Planet) -> View {
        self.draw.view(planet.camera_at(keyframe, self.size), planet, self.error)
    }

    fn look_at(&self, keyframe: &Keyframe, planet: &Planet) -> Look {
        let site = direction_at(keyframe.latitude, keyframe.longitude);
        self.draw.look.look(&planet.recipe, site, Exposure::Fixed(1.0))
    }
}

/// Makes a file of the planet of another that holds its six whole faces.
fn bake_faces(of: &Path, out: &Path) -> anyhow::Result<Planet> {
    let header = PlanetFile::open(of)?.header().clone();
    let planet = Planet::from_header(&header)?;
    let mut file = PlanetFile::create_or_resume(out, &header)?;
    let plan = BakePlan::new(planet.recipe.radius, 0, None)?;
    let threads = Threads::default().count();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, threads, &|_| (), &AtomicBool::new(false))
        .with_context(|| format!("cannot bake {}", out.display()))?;
    Ok(planet)
}

/// Waits until nothing is asked for that surrounds a settled view. Whether that came to pass in time.
fn surround(scene: &mut Scene, view: &View) -> Result<bool, SceneError> {
    let begun = Instant::now();
    let mut quiet = Instant::now();
    while begun.elapsed() < LONGEST_WAIT {
        scene.update(view, usize::MAX)?;
        if scene.pending() > 0 || !scene.is_settled() {
            quiet = Instant::now();
        } else if quiet.elapsed() >= QUIET {
            return Ok(true);
        }
        sleep(PAUSE);
    }
    Ok(false)
}
