//! `terrane verify`: random views of a planet on the GPU, against the CPU and the invariants.

use super::viewing::GpuOptions;
use super::Run;
use crate::Outcome;
use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::verify::{random_views, Verifier, VerifyReport, ViewReport};
use terrane::vulkan::GpuInfo;
use terrane_planet::view::View;

/// Pictures are not drawn: the smallest targets will do.
const SIZE: (u32, u32) = (16, 16);

/// Check random views of a planet: no cracks, no flips, the same mesh on GPU and CPU.
#[derive(clap::Args)]
pub(crate) struct Verify {
    /// Planet file.
    file: PathBuf,
    /// Number of views.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    views: u32,
    /// Seed of the views: the same seed gives the same views of the same file.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    gpu: GpuOptions,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Verify {
    fn run(self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        let context = self.gpu.context()?;
        let mut scene = Scene::open(&context, &self.file, SceneOptions::whole_mesh())?;
        let mut headless = Headless::new(&context, SIZE)?;
        let mut verifier = Verifier::new(&self.file, &scene)?;
        let views = random_views(&scene, self.seed, self.views as usize);
        let progress = Progress::new(views.len());
        let mut report = VerifyReport::default();
        for (k, view) in views.iter().enumerate() {
            let seen = verifier.check(&mut scene, &mut headless, view)?;
            report.add(&seen);
            progress.show(k, view, &seen, begun);
        }
        progress.finish();
        let seconds = begun.elapsed().as_secs_f64();
        if self.json {
            println!("{}", summary(&report, context.device_info(), seconds));
        } else {
            print(&report, seconds);
        }
        self.gpu.report_messages(&context)?;
        match report.broken_promises() {
            promises if promises.is_empty() => Ok(Outcome::Done),
            promises => bail!("{}: {}", self.file.display(), promises.join(", ")),
        }
    }
}

fn summary(r: &VerifyReport, gpu: &GpuInfo, seconds: f64) -> serde_json::Value {
    let m = &r.mismatches;
    json!({
        "views": r.views, "uncertified_views": r.uncertified_views, "patches": r.patches, "triangles": r.triangles,
        "most_triangles": r.most_triangles, "triangles_after_culling": r.triangles_after_culling, "cracks": r.cracks,
        "flipped": r.faults.flipped, "degenerate": r.faults.degenerate, "closure_violations": r.faults.closure_violations,
        "flipped_at_data_rim": r.faults_at_data_rim.flipped, "degenerate_at_data_rim": r.faults_at_data_rim.degenerate,
        "closure_violations_at_data_rim": r.faults_at_data_rim.closure_violations,
        "flipped_uncertified": r.faults_uncertified.flipped, "degenerate_uncertified": r.faults_uncertified.degenerate,
        "closure_violations_uncertified": r.faults_uncertified.closure_violations,
        "broken_hierarchies": r.broken_hierarchies, "dropped_triangles": r.dropped, "gpu_cpu_mismatches": m.total(),
        "mismatches": { "patches": m.patches, "awake": m.awake, "resolved": m.resolved, "triangles": m.triangles,
            "culled_triangles": m.culled_triangles, "counters": m.counters },
        "seconds": seconds, "device": gpu.name, "driver": gpu.driver, "driver_info": gpu.driver_info,
        "subgroup_size": gpu.subgroup_size,
    })
}

fn print(r: &VerifyReport, seconds: f64) {
    println!("{} views, {} of them not certified, in {seconds:.0} s", r.views, r.uncertified_views);
    println!("{} patches, {} triangles, at most {} in a view", r.patches, r.triangles, r.most_triangles);
    println!("{} cracks, {} differences between GPU and CPU", r.cracks, r.mismatches.total());
    for (where_, faults) in [
        ("certified", r.faults),
        ("at the rim of the data", r.faults_at_data_rim),
        ("in views that are not certified", r.faults_uncertified),
    ] {
        let (flipped, degenerate, closure) = (faults.flipped, faults.degenerate, faults.closure_violations);
        println!("  {where_}: {flipped} flipped, {degenerate} without area, {closure} breaches of closure");
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

    fn show(&self, k: usize, view: &View, seen: &ViewReport, begun: Instant) {
        let mut alone = VerifyReport::default();
        alone.add(seen);
        let faults = alone.broken_promises().join(", ");
        let eye = view.camera.position;
        let place = format!("camera {} {} {} m, {} px", eye.x, eye.y, eye.z, view.tolerance);
        match &self.bar {
            Some(bar) => {
                bar.inc(1);
                if !faults.is_empty() {
                    bar.suspend(|| eprintln!("view {k}, {place}: {faults}"));
                }
            }
            None => {
                let seconds = begun.elapsed().as_secs_f64();
                let verdict = if faults.is_empty() { String::new() } else { format!(" ({place}): {faults}") };
                eprintln!("{}/{} views, {seconds:.0} s: {} triangles{verdict}", k + 1, self.views, seen.triangles);
            }
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
