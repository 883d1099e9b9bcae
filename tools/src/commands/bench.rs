//! `terrane bench`: what the frames of a camera path cost.

mod first_look;
mod live;
mod percentiles;
mod process;
mod savings;

use super::drawing::DrawOptions;
use super::output::{check_output, Output};
use super::paths::{self, GivenPath};
use super::planets::{planet_file, FILE, HELP};
use super::stage_times::stage_times;
use super::viewing::{check_tolerance, numbers, picture_size};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::Context as _;
use percentiles::{summarise, Line};
use savings::VARIANTS;
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::time::Duration;
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::measure::{measure_frame, FrameCost};
use terrane::scene::{Scene, Scope};
use terrane::vulkan::GpuInfo;
use terrane_planet::draw::camera_path::{Keyframe, Waypoint};
use terrane_planet::planet::Planet;
use terrane_planet::store::slow::Delay;

/// Measure the frames along a camera path: steady costs, after the patches of each frame have been loaded.
///
/// A path is a JSON list of keyframes {time_s, latitude, longitude, altitude_m, heading, pitch, fov}: degrees, and metres above the ground
/// or the sea; or height_m, above the datum. {"pace": "constant", "keyframes": […]} makes the speed follow the altitude. Frames stand at
/// equal steps of time. docs/paths.md says what lies between keyframes.
#[derive(clap::Args)]
pub(crate) struct Bench {
    #[arg(value_name = FILE, help = HELP)]
    file: PathBuf,
    #[arg(long, value_name = paths::VALUE, help = paths::HELP, required_unless_present = "first_look")]
    path: Option<PathBuf>,
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
    /// Draw every frame again without each of selection's economies, and with the orientation term, and show what that changes.
    #[arg(long)]
    savings: bool,
    /// Fly instead: no frame waits for patches, each draws what has arrived. Says what was built, and when nothing was missing any more.
    #[arg(long, conflicts_with = "savings")]
    live: bool,
    /// With `--live`: check every frame's surface and picture for cracks and holes, outside of its times; any is an error.
    #[arg(long, requires = "live")]
    check: bool,
    /// Measure single pictures instead, each from nothing (in a temporary planet file of the same planet that holds the six cube faces),
    /// then from the file that holds all that it shows; and what a turn by 90 degrees finds once the surroundings are there.
    ///
    /// CPU time and memory are those of this process, with what a software renderer takes; times count from opening the device and the
    /// file, without drawing. Views: on Terra the way down of tools/run and mountains; on other planets the highest of 200 sites, from
    /// 300 km, 1 km and 50 m. The given file is only read.
    #[arg(long, conflicts_with_all = ["path", "live", "savings"])]
    first_look: bool,
    /// With `--first-look`: each view once more with its planet file at the other end of a line, given as latency and bytes a second.
    #[arg(long, value_name = "20ms,1MB/s", value_parser = delay, requires = "first_look")]
    source_delay: Option<Delay>,
    /// With `--first-look`: only this view, latitude and longitude in degrees and metres above the ground or the sea.
    #[arg(long, value_name = "LAT,LON,ALT_M", value_parser = numbers::<3>, allow_hyphen_values = true, requires = "first_look")]
    at: Option<[f64; 3]>,
    /// With `--at`: degrees clockwise from north, and degrees above the horizontal.
    #[arg(long, value_name = "HEADING,PITCH", value_parser = numbers::<2>, allow_hyphen_values = true, requires = "at")]
    look: Option<[f64; 2]>,
    #[command(flatten)]
    draw: DrawOptions,
    /// JSON file to write: what was measured on what, percentiles, and the row of every frame.
    #[arg(long, value_name = "OUT")]
    json: Option<PathBuf>,
}

impl Run for Bench {
    fn run(mut self) -> anyhow::Result<Outcome> {
        if let Some(out) = &self.json {
            check_output("--json", out, Output::File(&[]))?;
        }
        let place = planet_file(Some(&self.file), None)?;
        self.file = place.path().to_owned();
        if self.first_look {
            self.first_looks()?;
            return Ok(Outcome::Done);
        }
        check_tolerance(self.error)?;
        let path = GivenPath::read(self.path())?;
        let scope = if self.live { Scope::Flight } else { Scope::Still };
        let (context, mut scene) = self.draw.open_for(&place, scope)?;
        let path = path.over(scene.planet())?;
        let [width, height] = self.size;
        let mut headless = Headless::new(&context, (width, height))?;
        if self.live {
            let flight = self.fly(&context, &mut scene, &mut headless, &path)?;
            self.print_heading(context.device_info());
            flight.print(self.check)?;
            if let Some(out) = &self.json {
                let mut report = self.report(context.device_info());
                report["flight"] = flight.report()?;
                write_report(out, &report)?;
            }
            self.draw.gpu.report_messages(&context)?;
            flight.verdict()?;
            return Ok(Outcome::Done);
        }
        let (first, last) = path.span();
        let step = (last - first) / f64::from(self.frames - 1);
        let look = self.draw.look_along(&scene.planet().recipe, &path);
        for _ in 0..self.warmup {
            self.measure(&mut scene, &mut headless, &look.at(first), &path.at(first), |view, _| view)?;
        }
        let variants = if self.savings { &VARIANTS[..] } else { &VARIANTS[..1] };
        let (mut waypoints, mut costs) = (Vec::new(), vec![Vec::new(); variants.len()]);
        for frame in 0..self.frames {
            let waypoint = path.at(first + step * f64::from(frame));
            let look = look.at(waypoint.time_s);
            for ((_, change), costs) in variants.iter().zip(&mut costs) {
                costs.push(self.measure(&mut scene, &mut headless, &look, &waypoint, *change)?);
            }
            waypoints.push(waypoint);
        }
        let summary = summarise(&costs[0])?;
        let device = context.device_info();
        self.print_heading(device);
        print_table(&summary);
        if self.savings {
            savings::print(&costs);
        }
        if let Some(out) = &self.json {
            let mut report = self.report(device);
            report["summary"] = summary.iter().map(percentiles_of).collect::<serde_json::Map<_, _>>().into();
            let planet = scene.planet();
            report["rows"] = waypoints.iter().zip(&costs[0]).map(|(waypoint, cost)| row(waypoint, planet, cost)).collect();
            if self.savings {
                report["savings"] = savings::report(&costs);
            }
            write_report(out, &report)?;
        }
        self.draw.gpu.report_messages(&context)?;
        Ok(Outcome::Done)
    }
}

impl Bench {
    fn measure(
        &self,
        scene: &mut Scene,
        headless: &mut Headless,
        look: &Look,
        waypoint: &Waypoint,
        change: savings::Change,
    ) -> anyhow::Result<FrameCost> {
        let planet = scene.planet();
        let view = change(self.draw.view(planet.camera_on(waypoint, self.size), planet, self.error), planet);
        Ok(measure_frame(scene, headless, &view, look)?)
    }

    fn path(&self) -> &Path {
        self.path.as_deref().unwrap_or(Path::new(""))
    }

    /// What was measured on what, along a path.
    fn report(&self, device: &GpuInfo) -> Value {
        let mut report = self.setting(device);
        report["path"] = json!(self.path());
        report["frames"] = self.frames.into();
        report["warmup"] = self.warmup.into();
        report
    }

    /// What was measured on what.
    fn setting(&self, device: &GpuInfo) -> Value {
        json!({
            "device": device.name, "driver": device.driver, "driver_info": device.driver_info,
            "commit": env!("TERRANE_COMMIT"), "version": env!("CARGO_PKG_VERSION"),
            "planet": self.file, "size": self.size, "tolerance_px": self.error,
            "geomorphs": self.draw.mesh.geomorphs(), "orientation": self.draw.mesh.orientation(),
        })
    }

    fn print_heading(&self, device: &GpuInfo) {
        let [width, height] = self.size;
        println!("{} ({} {})", device.name, device.driver, device.driver_info);
        println!(
            "{} frames of {} at {width}x{height}, {} px{}, commit {}",
            self.frames,
            self.path().display(),
            self.error,
            self.draw.mesh.describe(),
            env!("TERRANE_COMMIT")
        );
    }
}

/// A latency in milliseconds and a rate in bytes, kilobytes or megabytes a second, such as 20ms,1MB/s.
fn delay(text: &str) -> anyhow::Result<Delay> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| (0.001..=1e9).contains(number));
    let rate = |text: &str| {
        let unit = [("MB/s", 1e6), ("kB/s", 1e3), ("B/s", 1.0)].into_iter().find(|(unit, _)| text.trim().ends_with(unit))?;
        number(text.trim().strip_suffix(unit.0)?).map(|number| number * unit.1)
    };
    let parts = text.split_once(',');
    let latency = parts.and_then(|(latency, _)| number(latency.trim().strip_suffix("ms")?));
    let bytes_per_second = parts.and_then(|(_, bytes)| rate(bytes));
    let both = latency.zip(bytes_per_second);
    let (latency, bytes_per_second) = both.with_context(|| format!("'{text}' is not a latency and a rate such as 20ms,1MB/s"))?;
    Ok(Delay { latency: Duration::from_secs_f64(1e-3 * latency), bytes_per_second })
}

fn write_report(out: &Path, report: &Value) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(report)?;
    pictures::write_whole(out, text.as_bytes()).with_context(|| format!("cannot write the results {}", out.display()))
}

fn percentiles_of(line: &Line) -> (String, Value) {
    let [p50, p95, p99, max] = line.at;
    (line.name.clone(), json!({ "p50": p50, "p95": p95, "p99": p99, "max": max, "frames": line.frames }))
}

fn row(waypoint: &Waypoint, planet: &Planet, c: &FrameCost) -> Value {
    let Keyframe { time_s, latitude, longitude, stand, heading, pitch, fov } = waypoint.keyframe();
    json!({
        "time_s": time_s, "latitude": latitude, "longitude": longitude, "altitude_m": planet.altitude_of(waypoint.up, stand),
        "heading": heading, "pitch": pitch, "fov": fov,
        "settle_ms": c.settle_ms, "cut_ms": c.cut_ms, "tables_ms": c.tables_ms, "record_ms": c.record_ms,
        "stages_gpu_ms": stage_times(&c.stages_ms), "gpu_wall_ms": c.gpu_wall_ms, "frame_ms": c.frame_ms,
        "triangles": c.triangles, "awake_vertices": c.awake, "prefix_vertices": c.prefix_vertices,
        "candidate_triangles": c.candidate_triangles, "patches": c.patches, "resident_patches": c.resident,
    })
}

fn print_table(summary: &[Line]) {
    println!("{:<20} {:>12} {:>12} {:>12} {:>12}", "", "p50", "p95", "p99", "max");
    for line in summary.iter().filter(|l| l.frames > 0) {
        let [p50, p95, p99, max] = line.at.map(|v| format!("{v:.digits$}", digits = line.digits));
        println!("{:<20} {p50:>12} {p95:>12} {p99:>12} {max:>12}", line.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_have_units() {
        let read = |text| delay(text).map(|delay| (delay.latency.as_secs_f64(), delay.bytes_per_second));
        assert_eq!(read("20ms,1MB/s").unwrap(), (0.02, 1e6));
        assert_eq!(read("0.5ms, 300kB/s").unwrap(), (0.0005, 3e5));
        for wrong in ["20ms", "20,1MB/s", "20ms,1", "20ms,0MB/s", "-1ms,1MB/s", "ms,B/s"] {
            assert!(read(wrong).unwrap_err().to_string().contains("such as 20ms,1MB/s"), "{wrong}");
        }
    }
}
