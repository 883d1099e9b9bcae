//! `terrane verify`: random views of a planet on the GPU, against the CPU and the invariants; and their screen error, with rays.

use super::planets::{built_planet_file, planet_file, PlanetPlace, FILE, HELP};
use super::viewing::{check_tolerance, GpuOptions, MeshOptions, PatchOptions};
use super::Run;
use crate::Outcome;
use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{json, Value};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions, Scope};
use terrane::verify::screen::ToleranceErrors;
use terrane::verify::{ground_views, random_views, Perturbation, ScreenErrors, Verifier, VerifyReport, ViewReport, TOLERANCES};
use terrane::vulkan::GpuInfo;
use terrane_planet::draw::view::View;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::verify::{ErrorReadings, Probe, Reading, ScreenError};

/// Pictures are not drawn: the smallest targets will do.
const SIZE: (u32, u32) = (16, 16);

/// Bytes of patches near the ground: a view that got fewer than it wants proves nothing.
const NEAR_GROUND_BYTES: u64 = 4 << 30;

/// Check random views of a planet: no cracks, no flips, the same mesh on GPU and CPU, errors within the tolerance.
///
/// The screen error is the radial distance between what is drawn and the finest surface in the file, in pixels as the camera sees it.
/// Rays measure it at every sleeping vertex in view, at random pixels and at samples of finer patches, also for cuts that split more
/// than they must and for cuts with patches missing.
#[derive(clap::Args)]
pub(crate) struct Verify {
    #[arg(value_name = FILE, help = HELP)]
    file: PathBuf,
    /// Number of views.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    views: u32,
    /// Seed of the views: the same seed gives the same views of the same file.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Tolerances in pixels, in turn.
    #[arg(long, value_name = "PX,PX...", value_delimiter = ',', default_values_t = TOLERANCES)]
    error: Vec<f64>,
    /// Random pixels a view at which rays measure the screen error, and as many samples of finer patches.
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(0..=100_000_000))]
    rays: u32,
    /// Take the views near the ground instead, at so many random sites on land, with patches built down to `--spacing`. They are
    /// kept in the file, as when flying.
    #[arg(long, value_name = "SITES", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    ground: Option<u32>,
    /// With `--ground`: build patches until their samples are this far apart.
    #[arg(long, value_name = "METRES", default_value_t = 1.0, requires = "ground")]
    spacing: f64,
    #[command(flatten)]
    mesh: MeshOptions,
    #[command(flatten)]
    gpu: GpuOptions,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Verify {
    fn run(self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        self.error.iter().try_for_each(|&error| check_tolerance(error))?;
        let context = self.gpu.context()?;
        let place = match self.ground {
            Some(_) => planet_file(Some(&self.file), None)?,
            None => built_planet_file(Some(&self.file), None)?,
        };
        let mut scene = Scene::open(&context, place.path(), self.scene_options(&place)?)?;
        let mut headless = Headless::new(&context, SIZE)?;
        let mut verifier = Verifier::new(place.path(), &scene)?;
        let count = self.views as usize;
        let views = match self.ground {
            None => random_views(&scene, self.seed, count, &self.error),
            Some(sites) => ground_views(&scene, self.seed, sites as usize, count, &self.error),
        };
        let views: Vec<View> = views.into_iter().map(|view| self.mesh.apply(view, scene.planet())).collect();
        let progress = Progress::new(views.len());
        let (mut report, mut errors) = (VerifyReport::default(), ScreenErrors::default());
        for (k, view) in views.iter().enumerate() {
            if self.ground.is_some() {
                // Copies of a site's patches take gigabytes.
                verifier.forget();
            }
            let seen = verifier.check(&mut scene, &mut headless, view)?;
            report.add(&seen);
            let mut largest = 0.0f64;
            for perturbation in Perturbation::of_view(k) {
                let screen = verifier.screen_error(scene.tree(), view, k, perturbation, self.rays as usize)?;
                errors.add(k, view, perturbation, &screen);
                largest = largest.max(screen.error.readings.max());
            }
            progress.show(k, view, &seen, largest, begun);
        }
        progress.finish();
        errors.by_tolerance.iter().for_each(describe_worst);
        let seconds = begun.elapsed().as_secs_f64();
        if self.json {
            println!("{}", summary(&report, &errors, context.device_info(), scene.tally().built, seconds));
        } else {
            print(&report, &errors, seconds);
        }
        self.gpu.report_messages(&context)?;
        let promises = [report.sum.broken_promises(), errors.broken_promises()].concat();
        if !promises.is_empty() {
            bail!("{}: {}", self.file.display(), promises.join(", "));
        }
        Ok(Outcome::Done)
    }
}

impl Verify {
    /// Everything in the file; near the ground also what is not, with room for the patches of a site.
    fn scene_options(&self, place: &PlanetPlace) -> anyhow::Result<SceneOptions> {
        if self.ground.is_none() {
            return Ok(SceneOptions::whole_mesh());
        }
        let options = PatchOptions::to_spacing(self.spacing).options()?;
        let scope = Scope::Whole;
        let published = place.published().cloned();
        Ok(SceneOptions { textures: false, gpu_bytes: NEAR_GROUND_BYTES, host_bytes: u64::MAX, scope, published, ..options })
    }
}

fn summary(r: &VerifyReport, errors: &ScreenErrors, gpu: &GpuInfo, built: u64, seconds: f64) -> Value {
    let sum = &r.sum;
    let m = &sum.mismatches;
    let worst = errors.worst();
    json!({
        "views": r.views, "patches_built": built, "patches": sum.patches, "triangles": sum.triangles,
        "most_triangles": r.most_triangles, "triangles_after_culling": sum.triangles_after_culling, "cracks": sum.cracks,
        "flipped": sum.faults.flipped, "degenerate": sum.faults.degenerate, "closure_violations": sum.faults.closure_violations,
        "flipped_at_data_rim": sum.faults_at_data_rim.flipped, "degenerate_at_data_rim": sum.faults_at_data_rim.degenerate,
        "closure_violations_at_data_rim": sum.faults_at_data_rim.closure_violations,
        "broken_hierarchies": sum.broken_hierarchies, "dropped_triangles": sum.dropped, "gpu_cpu_mismatches": m.total(),
        "mismatches": { "patches": m.patches, "awake": m.awake, "places": m.drawn_positions, "resolved": m.resolved, "triangles": m.triangles,
            "culled_triangles": m.culled_triangles, "counters": m.counters },
        "tolerance_px": worst.map(|t| t.tolerance), "screen_error_px": worst.map(|t| percentiles(&t.error.readings)),
        "screen_errors": errors.by_tolerance.iter().map(tolerance).collect::<Vec<_>>(),
        "perturbed_cracks": errors.cracks, "perturbed_flipped": errors.flipped,
        "seconds": seconds, "device": gpu.name, "driver": gpu.driver, "driver_info": gpu.driver_info,
        "subgroup_size": gpu.subgroup_size,
    })
}

fn tolerance(t: &ToleranceErrors) -> Value {
    json!({
        "tolerance_px": t.tolerance, "views": t.views, "share_of_tolerance": t.share(),
        "screen_error_px": percentiles(&t.error.readings), "readings": t.error.readings.count(),
        "missed": t.error.missed, "in_the_dark": t.error.in_the_dark,
        "at_data_rim_px": percentiles(&t.error.at_data_rim), "readings_at_data_rim": t.error.at_data_rim.count(),
        "worst": t.error.readings.worst().zip(t.worst_view).map(|(reading, view)| reading_json(reading, view)),
    })
}

fn percentiles(readings: &ErrorReadings) -> Value {
    let [p50, p99, p999] = [0.5, 0.99, 0.999].map(|share| readings.percentile(share));
    let [pixels, vertices, finer] = [Probe::Pixel, Probe::Sleeper, Probe::FinerSample].map(|probe| readings.max_of(probe));
    let by_probe = json!({ "pixels": pixels, "sleeping_vertices": vertices, "finer_samples": finer });
    json!({ "p50": p50, "p99": p99, "p999": p999, "max": readings.max(), "max_by_probe": by_probe })
}

fn reading_json(reading: &Reading, (view, perturbation): (usize, Perturbation)) -> Value {
    let (latitude, longitude) = latitude_longitude(reading.direction);
    json!({
        "view": view, "cut": perturbation.name(), "patch": reading.patch.to_string(), "probe": reading.probe.to_string(),
        "latitude": latitude, "longitude": longitude, "drawn_radius_m": reading.drawn_m, "finest_radius_m": reading.finest_m,
        "distance_m": reading.distance_m, "error_px": reading.pixels,
    })
}

/// Where the largest error of a tolerance was, on stderr.
fn describe_worst(t: &ToleranceErrors) {
    let Some((worst, (view, perturbation))) = t.error.readings.worst().zip(t.worst_view) else { return };
    let (latitude, longitude) = latitude_longitude(worst.direction);
    eprintln!(
        "largest error at {} px: {:.3} px in view {view} ({}), {} of {} at {latitude:.6},{longitude:.6}: drawn {:.3} m off, seen from {:.1} m",
        t.tolerance,
        worst.pixels,
        perturbation.name(),
        worst.probe,
        worst.patch,
        worst.drawn_m - worst.finest_m,
        worst.distance_m
    );
}

fn print(r: &VerifyReport, errors: &ScreenErrors, seconds: f64) {
    println!("{} views in {seconds:.0} s", r.views);
    let sum = &r.sum;
    println!("{} patches, {} triangles, at most {} in a view", sum.patches, sum.triangles, r.most_triangles);
    println!("{} cracks, {} differences between GPU and CPU", sum.cracks, sum.mismatches.total());
    for (where_, faults) in [("everywhere else", sum.faults), ("at the rim of the data", sum.faults_at_data_rim)] {
        let (flipped, degenerate, closure) = (faults.flipped, faults.degenerate, faults.closure_violations);
        println!("  {where_}: {flipped} flipped, {degenerate} without area, {closure} breaches of closure");
    }
    for t in &errors.by_tolerance {
        let ScreenError { readings, at_data_rim, missed, in_the_dark } = &t.error;
        let [p50, p99, p999] = [0.5, 0.99, 0.999].map(|share| readings.percentile(share));
        println!("screen error at {} px, {} views, {} readings, {missed} missed:", t.tolerance, t.views, readings.count());
        println!("  p50 {p50:.3}, p99 {p99:.3}, p99.9 {p999:.3}, max {:.3} px ({:.3} of it)", readings.max(), t.share());
        println!("  at the rim of the data max {:.3} px; {in_the_dark} more readings in the dark of the sea", at_data_rim.max());
    }
}

/// Progress on stderr: a bar on a terminal, a line for each view otherwise. Faulty views are described either way.
struct Progress {
    bar: Option<ProgressBar>,
    views: usize,
}

impl Progress {
    fn new(views: usize) -> Progress {
        let style = ProgressStyle::with_template("[{elapsed_precise}] {wide_bar} {pos}/{len} views, {eta} left");
        let bar = std::io::stderr().is_terminal().then(|| ProgressBar::new(views as u64));
        if let (Some(bar), Ok(style)) = (&bar, style) {
            bar.set_style(style);
        }
        Progress { bar, views }
    }

    fn show(&self, k: usize, view: &View, seen: &ViewReport, error: f64, begun: Instant) {
        let faults = seen.broken_promises().join(", ");
        let eye = view.camera.position;
        let seen_from = format!("camera {} {} {} m, {} px", eye.x, eye.y, eye.z, view.tolerance);
        match &self.bar {
            Some(bar) => {
                bar.inc(1);
                if !faults.is_empty() {
                    bar.suspend(|| eprintln!("view {k}, {seen_from}: {faults}"));
                }
            }
            None => {
                let seconds = begun.elapsed().as_secs_f64();
                let verdict = if faults.is_empty() { String::new() } else { format!(" ({seen_from}): {faults}") };
                let counts = format!("{} triangles, {error:.3} of {} px", seen.triangles, view.tolerance);
                eprintln!("{}/{} views, {seconds:.0} s: {counts}{verdict}", k + 1, self.views);
            }
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
