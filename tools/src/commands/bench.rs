//! `terrane bench`: what the frames of a camera path cost.

use super::paths::load_path;
use super::viewing::{camera_over, picture_size, GpuOptions, LookOptions, MeshOptions, PatchOptions};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{ensure, Context as _};
use hdrhistogram::Histogram;
use serde_json::{json, Value};
use std::path::PathBuf;
use terrane::frame::STAGES;
use terrane::headless::Headless;
use terrane::measure::{measure_frame, FrameCost};
use terrane::scene::Scene;
use terrane::vulkan::GpuInfo;
use terrane_planet::camera_path::Keyframe;
use terrane_planet::sphere::direction_at;
use terrane_planet::view::{View, TOLERANCE_RANGE};

/// Longest time that histograms hold, in microseconds; longer ones count as this.
const LONGEST_US: u64 = 600_000_000;

/// Measure the frames along a camera path: steady costs, after the patches of each frame have been loaded.
///
/// A path is a JSON list of keyframes {time_s, latitude, longitude, altitude_m, heading, pitch, fov}: degrees, and metres above
/// the ground or the sea. Frames stand at equal steps of time. Between keyframes every quantity follows a smooth curve that never
/// overshoots; altitudes by their logarithms, angles the short way.
#[derive(clap::Args)]
pub(crate) struct Bench {
    /// Planet file.
    file: PathBuf,
    /// Keyframes: a JSON file, or `descent` or `flyover`, which come with the command.
    #[arg(long, value_name = "PATH.json|NAME")]
    path: PathBuf,
    /// Frames to measure.
    #[arg(long, default_value_t = 120, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: u32,
    /// Frames at the start of the path to draw beforehand.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=1000))]
    warmup: u32,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = picture_size)]
    size: [u32; 2],
    /// Largest error of the mesh in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1.0)]
    error: f64,
    #[command(flatten)]
    mesh: MeshOptions,
    #[command(flatten)]
    patches: PatchOptions,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    gpu: GpuOptions,
    /// JSON file to write: what was measured on what, percentiles, and the row of every frame.
    #[arg(long, value_name = "OUT")]
    json: Option<PathBuf>,
}

impl Run for Bench {
    fn run(self) -> anyhow::Result<Outcome> {
        let (least, most) = TOLERANCE_RANGE;
        ensure!((least..=most).contains(&self.error), "--error: {} is not within {least} and {most} pixels", self.error);
        let path = load_path(&self.path)?;
        let context = self.gpu.context()?;
        let mut scene = Scene::open(&context, &self.file, self.patches.options()?)?;
        let [width, height] = self.size;
        let mut headless = Headless::new(&context, (width, height))?;
        let (first, last) = path.span();
        let step = (last - first) / f64::from(self.frames - 1);
        for _ in 0..self.warmup {
            self.measure(&mut scene, &mut headless, &path.at(first))?;
        }
        let mut rows = Vec::new();
        for frame in 0..self.frames {
            let stand = path.at(first + step * f64::from(frame));
            rows.push((stand, self.measure(&mut scene, &mut headless, &stand)?));
        }
        let costs: Vec<FrameCost> = rows.iter().map(|(_, cost)| *cost).collect();
        let summary = summarise(&costs)?;
        let device = context.device_info();
        print_table(&summary, device, &self);
        if let Some(out) = &self.json {
            let text = serde_json::to_string_pretty(&self.report(device, &summary, &rows))?;
            pictures::write_whole(out, text.as_bytes()).with_context(|| format!("cannot write the results {}", out.display()))?;
        }
        self.gpu.report_messages(&context)?;
        Ok(Outcome::Done)
    }
}

impl Bench {
    fn measure(&self, scene: &mut Scene, headless: &mut Headless, stand: &Keyframe) -> anyhow::Result<FrameCost> {
        let camera = camera_over(scene.planet(), stand, self.size);
        let view = self.mesh.apply(View::new(camera, scene.lattice(), scene.planet().cells, self.error));
        let look = self.look.look(direction_at(stand.latitude, stand.longitude));
        Ok(measure_frame(scene, headless, &view, &look)?)
    }

    fn report(&self, device: &GpuInfo, summary: &[Line], rows: &[(Keyframe, FrameCost)]) -> Value {
        let percentiles: serde_json::Map<_, _> = summary
            .iter()
            .map(|l| {
                (l.name.clone(), json!({ "p50": l.at[0], "p95": l.at[1], "p99": l.at[2], "max": l.at[3], "frames": l.frames }))
            })
            .collect();
        json!({
            "device": device.name, "driver": device.driver, "driver_info": device.driver_info,
            "commit": env!("TERRANE_COMMIT"), "version": env!("CARGO_PKG_VERSION"),
            "planet": self.file, "path": self.path, "size": self.size, "tolerance_px": self.error,
            "geomorphs": self.mesh.geomorphs(),
            "frames": self.frames, "warmup": self.warmup, "summary": percentiles,
            "rows": rows.iter().map(|(stand, cost)| row(stand, cost)).collect::<Vec<_>>(),
        })
    }
}

fn row(stand: &Keyframe, c: &FrameCost) -> Value {
    let stages: serde_json::Map<_, _> =
        STAGES.iter().zip(c.stages_ms).filter_map(|(stage, ms)| Some(((*stage).to_owned(), json!(ms?)))).collect();
    json!({
        "time_s": stand.time_s, "latitude": stand.latitude, "longitude": stand.longitude, "altitude_m": stand.altitude_m,
        "heading": stand.heading, "pitch": stand.pitch, "fov": stand.fov,
        "settle_ms": c.settle_ms, "cut_ms": c.cut_ms, "tables_ms": c.tables_ms, "record_ms": c.record_ms,
        "stages_gpu_ms": stages, "gpu_wall_ms": c.gpu_wall_ms, "frame_ms": c.frame_ms,
        "triangles": c.triangles, "awake_vertices": c.awake, "prefix_vertices": c.prefix_vertices,
        "candidate_triangles": c.candidate_triangles, "patches": c.patches, "resident_patches": c.resident,
    })
}

/// Percentiles of one quantity: 50, 95, 99 and the largest.
struct Line {
    name: String,
    at: [f64; 4],
    frames: usize,
}

/// A quantity of a frame; `None` where a frame lacks it.
type Quantity = (String, Box<dyn Fn(&FrameCost) -> Option<f64>>);

fn quantities() -> Vec<Quantity> {
    let plain = |name: &str, value: fn(&FrameCost) -> f64| -> Quantity { (name.to_owned(), Box::new(move |c| Some(value(c)))) };
    let stage = |(k, name): (usize, &&str)| -> Quantity { (format!("gpu {name} ms"), Box::new(move |c| c.stages_ms[k])) };
    let mut all =
        vec![plain("cpu cut ms", |c| c.cut_ms), plain("cpu tables ms", |c| c.tables_ms), plain("cpu record ms", |c| c.record_ms)];
    all.extend(STAGES.iter().enumerate().map(stage));
    all.extend([
        plain("gpu wall ms", |c| c.gpu_wall_ms),
        plain("frame ms", |c| c.frame_ms),
        plain("settle ms (apart)", |c| c.settle_ms),
        plain("triangles", |c| f64::from(c.triangles)),
        plain("awake vertices", |c| f64::from(c.awake)),
        plain("prefix vertices", |c| f64::from(c.prefix_vertices)),
        plain("candidate triangles", |c| f64::from(c.candidate_triangles)),
        plain("patches", |c| c.patches as f64),
        plain("resident patches", |c| c.resident as f64),
    ]);
    all
}

/// Percentiles of all quantities. Times are kept in microseconds to three digits.
fn summarise(costs: &[FrameCost]) -> anyhow::Result<Vec<Line>> {
    let mut lines = Vec::new();
    for (name, value) in quantities() {
        let scale = if name.contains(" ms") { 1e3 } else { 1.0 };
        let mut histogram = Histogram::<u64>::new_with_bounds(1, LONGEST_US, 3)?;
        for ms in costs.iter().filter_map(value) {
            histogram.saturating_record((ms * scale).round() as u64);
        }
        let at = [0.50, 0.95, 0.99, 1.0].map(|q| histogram.value_at_quantile(q) as f64 / scale);
        lines.push(Line { name, at, frames: histogram.len() as usize });
    }
    Ok(lines)
}

fn print_table(summary: &[Line], device: &GpuInfo, bench: &Bench) {
    let [width, height] = bench.size;
    println!("{} ({} {})", device.name, device.driver, device.driver_info);
    println!(
        "{} frames of {} at {width}x{height}, {} px{}, commit {}",
        bench.frames,
        bench.path.display(),
        bench.error,
        if bench.mesh.geomorphs() { "" } else { ", no geomorphs" },
        env!("TERRANE_COMMIT")
    );
    println!("{:<20} {:>12} {:>12} {:>12} {:>12}", "", "p50", "p95", "p99", "max");
    for line in summary.iter().filter(|l| l.frames > 0) {
        let digits = if line.name.contains(" ms") { 3 } else { 0 };
        let [p50, p95, p99, max] = line.at.map(|v| format!("{v:.digits$}"));
        println!("{:<20} {p50:>12} {p95:>12} {p99:>12} {max:>12}", line.name);
    }
}
