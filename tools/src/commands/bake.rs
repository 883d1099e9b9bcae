//! `terrane bake`: builds the patches of a recipe into a planet file, or what is missing of them.

use super::Run;
use crate::Outcome;
use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::cell::Cell;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Duration;
use terrane_planet::bake::{bake, BakePlan, BakeSummary, Progress, Region};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::simplify::builder::Faults;
use terrane_planet::sphere::direction_at;
use terrane_planet::store::PlanetFile;

/// Time between two lines of progress where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Build the patches of a recipe into a planet file; go on where an earlier bake stopped.
#[derive(clap::Args)]
pub(crate) struct Bake {
    /// Recipe of the planet, a TOML file.
    recipe: PathBuf,
    /// Planet file to make or to go on with.
    #[arg(long, short)]
    out: PathBuf,
    /// Finest level of the whole planet; 0 is the six cube faces.
    #[arg(long, short)]
    levels: u8,
    /// Part to bake finer: latitude and longitude in degrees, radius in kilometres.
    #[arg(long, value_name = "LAT,LON,RADIUS_KM", requires = "to_level", allow_hyphen_values = true, value_parser = parse_region)]
    region: Option<RegionArgument>,
    /// Finest level inside the region.
    #[arg(long, value_name = "LEVEL", requires = "region")]
    to_level: Option<u8>,
    /// Grid cells along a patch side, a power of two.
    #[arg(long, default_value_t = 128)]
    cells: u32,
    /// Threads to build on [default: one a processor].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print the summary as one JSON object.
    #[arg(long)]
    json: bool,
}

/// What `--region` says.
#[derive(Clone, Copy)]
struct RegionArgument {
    latitude: f64,
    longitude: f64,
    radius_km: f64,
}

fn parse_region(text: &str) -> Result<RegionArgument, String> {
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse()).collect::<Result<_, _>>().unwrap_or_default();
    let &[latitude, longitude, radius_km] = numbers.as_slice() else {
        return Err("expected three numbers: latitude and longitude in degrees, radius in kilometres, such as 46.5,8,50".into());
    };
    if !(-90.0..=90.0).contains(&latitude) {
        return Err(format!("latitude {latitude}, expected -90 to 90 degrees"));
    }
    if !(-360.0..=360.0).contains(&longitude) {
        return Err(format!("longitude {longitude}, expected -180 to 180 degrees"));
    }
    if !(radius_km >= 0.0 && radius_km.is_finite()) {
        return Err(format!("radius {radius_km}, expected 0 or more kilometres"));
    }
    Ok(RegionArgument { latitude, longitude, radius_km })
}

impl Run for Bake {
    fn run(self) -> anyhow::Result<Outcome> {
        let planet = Planet::from_recipe(Recipe::load(&self.recipe)?, self.cells)?;
        let plan = BakePlan::new(planet.recipe.radius, self.levels, self.region())?;
        let mut file = PlanetFile::create_or_resume(&self.out, &planet.header())?;
        let stop = stop_on_signals()?;
        let threads = self.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()), usize::from);
        let report = Report::new(&planet.recipe.name);
        let summary = bake(&mut file, &planet.terrain, &planet.terrain, &plan, threads, &|p| report.show(p), &stop);
        report.finish();
        let summary = summary.with_context(|| format!("cannot bake {} into {}", self.recipe.display(), self.out.display()))?;
        self.print(&summary);
        Ok(if summary.interrupted { Outcome::Interrupted } else { Outcome::Done })
    }
}

impl Bake {
    fn region(&self) -> Option<Region> {
        let (region, to_level) = (self.region?, self.to_level?);
        let direction = direction_at(region.latitude, region.longitude);
        Some(Region { direction, radius_m: region.radius_km * 1e3, to_level })
    }

    fn print(&self, s: &BakeSummary) {
        let (seconds, rate, bytes) = (s.elapsed.as_secs_f64(), s.vertices_per_second(), s.bytes_per_vertex());
        let always = s.always_awake as f64 / s.built.max(1) as f64;
        if self.json {
            let summary = json!({
                "file": self.out.display().to_string(), "planned": s.planned, "built": s.built, "skipped": s.skipped,
                "interrupted": s.interrupted, "vertices": s.vertices, "seconds": seconds, "vertices_per_second": rate,
                "geometry_bytes": s.geometry_bytes, "bytes_per_vertex": bytes, "texture_bytes": s.texture_bytes,
                "always_awake_per_patch": always, "stuck_border": s.faults.stuck_border,
                "stuck_interior": s.faults.stuck_interior, "uncertified": s.faults.uncertified,
            });
            println!("{summary}");
            return;
        }
        let (out, left) = (self.out.display(), s.planned - s.built - s.skipped);
        println!("{out}: {} patches built, {} there before, {left} left", s.built, s.skipped);
        if s.built > 0 {
            println!("{:.1} s, {} vertices, {rate:.0} vertices/s", seconds, s.vertices);
            let megabytes = |b: u64| b as f64 / 1e6;
            println!(
                "geometry {:.1} MB ({bytes:.2} bytes a vertex), texture {:.1} MB",
                megabytes(s.geometry_bytes),
                megabytes(s.texture_bytes)
            );
            println!("{always:.1} vertices a patch always awake");
        }
        if s.faults != Faults::default() {
            println!("the builder broke its own rules: {:?}; the file is usable, please report this with the recipe", s.faults);
        }
        if s.interrupted {
            println!("interrupted: the same command goes on from here");
        }
    }
}

/// A flag that is raised by Ctrl-C, SIGTERM and SIGHUP; a second signal ends the process at once, which the file survives.
fn stop_on_signals() -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    ctrlc::set_handler(handler).context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// Progress on stderr: a bar on a terminal, a line now and then otherwise.
struct Report {
    bar: Option<ProgressBar>,
    name: String,
    last_line: Cell<Duration>,
}

impl Report {
    fn new(name: &str) -> Report {
        let style = ProgressStyle::with_template("{msg} [{elapsed_precise}] {wide_bar} {pos}/{len} patches, {eta} left");
        let bar = std::io::stderr().is_terminal().then(|| ProgressBar::new(0).with_message(name.to_owned()));
        if let (Some(bar), Ok(style)) = (&bar, style) {
            bar.set_style(style);
        }
        Report { bar, name: name.to_owned(), last_line: Cell::new(Duration::ZERO) }
    }

    fn show(&self, p: Progress) {
        if let Some(bar) = &self.bar {
            bar.set_length(p.total as u64);
            bar.set_position(p.built as u64);
        } else if p.elapsed >= self.last_line.get() + LINE_EVERY || p.built == p.total {
            self.last_line.set(p.elapsed);
            eprintln!("{}: {}/{} patches, {:.0} s", self.name, p.built, p.total, p.elapsed.as_secs_f64());
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
