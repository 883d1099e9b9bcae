//! `bench --live`: a flight along the path that waits for nothing, and what arrived meanwhile.

use super::{process, Bench};
use anyhow::bail;
use hdrhistogram::Histogram;
use serde_json::{json, Value};
use std::sync::Arc;
use std::time::Instant;
use terrane::headless::Headless;
use terrane::measure::live::{LiveFaults, LiveFlight, LiveFrame};
use terrane::scene::Scene;
use terrane::vulkan::Context;
use terrane_planet::draw::camera_path::CameraPath;

/// Frames at the end of the path after which nothing more is waited for.
const MOST_FRAMES_AT_END: usize = 20_000;

/// A frame.
struct Row {
    time_s: f64,
    altitude_m: f64,
    frame: LiveFrame,
    faults: LiveFaults,
}

/// A whole flight.
pub(super) struct Flight {
    rows: Vec<Row>,
    /// Frames at the end of the path until nothing was missing.
    at_end: Vec<LiveFrame>,
    built: u64,
    read: u64,
    build_s: f64,
    wall_s: f64,
    /// Bytes of patches: the most on the GPU and the most allowed there, then the same of main memory.
    bytes: [(u64, u64); 2],
    /// Bytes of everything on the GPU, at most.
    allocated: u64,
}

impl Bench {
    /// Flies along the path, then stays at its end until nothing is missing.
    pub(super) fn fly(
        &self,
        context: &Arc<Context>,
        scene: &mut Scene,
        headless: &mut Headless,
        path: &CameraPath,
    ) -> anyhow::Result<Flight> {
        let (first, last) = path.span();
        let step = (last - first) / f64::from(self.frames - 1);
        let planet = scene.shared_planet();
        let view = |camera| self.draw.view(camera, &planet, self.error);
        let begun = Instant::now();
        let (mut rows, mut at_end) = (Vec::new(), Vec::new());
        let mut host = 0;
        let mut checking = 0.0;
        let look = self.draw.look_along(&planet.recipe, path);
        let mut flight = LiveFlight::new(context, scene, headless, step);
        for number in 0..self.frames as usize + MOST_FRAMES_AT_END {
            let waypoint = path.at((first + step * number as f64).min(last));
            let look = look.at(waypoint.time_s);
            let (frame, seen, cut) = flight.frame(planet.camera_on(&waypoint, self.size), &view, &look)?;
            host = host.max(flight.scene().host_bytes().0);
            let check = Instant::now();
            let faults = if self.check { flight.faults(&seen, &cut, &look)? } else { LiveFaults::default() };
            checking += check.elapsed().as_secs_f64();
            let altitude_m = planet.altitude_of(waypoint.up, waypoint.stand);
            let row = Row { time_s: waypoint.time_s, altitude_m, frame, faults };
            if number < self.frames as usize {
                rows.push(row);
                continue;
            }
            at_end.push(frame);
            if faults.total() > 0 {
                rows.push(row);
            }
            if frame.settled {
                break;
            }
        }
        let wall_s = begun.elapsed().as_secs_f64() - checking;
        let tally = scene.tally();
        let frames = || rows.iter().map(|row| &row.frame).chain(&at_end);
        let gpu = frames().map(|frame| frame.gpu_bytes).max().unwrap_or(0);
        let allocated = frames().map(|frame| frame.allocated_bytes).max().unwrap_or(0);
        let bytes = [(gpu, scene.gpu_bytes().1), (host, scene.host_bytes().1)];
        Ok(Flight { rows, at_end, built: tally.built, read: tally.read, build_s: tally.build_s, wall_s, bytes, allocated })
    }
}

impl Flight {
    /// Milliseconds of the frames on the way: median, 95th percentile, worst.
    fn frame_ms(&self) -> anyhow::Result<[f64; 3]> {
        let mut histogram = Histogram::<u64>::new(3)?;
        for row in &self.rows {
            histogram.record((row.frame.frame_ms * 1e3) as u64)?;
        }
        Ok([0.5, 0.95, 1.0].map(|q| histogram.value_at_quantile(q) as f64 / 1e3))
    }

    fn faults(&self) -> LiveFaults {
        self.rows.iter().fold(LiveFaults::default(), |sum, Row { faults, .. }| LiveFaults {
            cracks: sum.cracks + faults.cracks,
            flipped: sum.flipped + faults.flipped,
            holes: sum.holes + faults.holes,
        })
    }

    /// Prints the table.
    pub(super) fn print(&self, checked: bool) -> anyhow::Result<()> {
        let [median, p95, worst] = self.frame_ms()?;
        let lifted = self.rows.iter().map(|row| row.frame.lifted_m).fold(0.0, f64::max);
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        println!("patches built          {:>8}   {:.1} a second, {:.0} ms each", self.built, self.rate(), self.build_ms());
        println!("patches read           {:>8}", self.read);
        println!("frames until settled   {:>8}   after the end of the path", self.at_end.len());
        println!(
            "frame ms, median       {median:>8.1}   p95 {p95:.1}, worst {worst:.1} ({:.1} times the median)",
            worst / median
        );
        for (name, (peak, most)) in ["GPU", "host"].iter().zip(self.bytes) {
            println!("{:<22} {:>8.0}   of {:.0}", format!("{name} MB of patches"), megabytes(peak), megabytes(most));
        }
        println!("GPU MB altogether      {:>8.0}", megabytes(self.allocated));
        if let Some(bytes) = process::peak_bytes() {
            println!("peak MB of the process {:>8.0}   with what the driver holds in main memory", megabytes(bytes));
        }
        println!("lifted out of ground   {lifted:>8.1} m");
        if checked {
            let LiveFaults { cracks, flipped, holes } = self.faults();
            println!("faults                 {cracks} cracks, {flipped} flipped, {holes} lines of sight without ground");
        }
        Ok(())
    }

    fn rate(&self) -> f64 {
        self.built as f64 / self.wall_s
    }

    fn build_ms(&self) -> f64 {
        1e3 * self.build_s / self.built.max(1) as f64
    }

    /// The same as JSON, with a row for each frame.
    pub(super) fn report(&self) -> anyhow::Result<Value> {
        let [median, p95, worst] = self.frame_ms()?;
        let faults = self.faults();
        let row = |Row { time_s, altitude_m, frame: f, faults }: &Row| {
            json!({
                "time_s": time_s, "altitude_m": altitude_m, "update_ms": f.update_ms, "frame_ms": f.frame_ms,
                "triangles": f.triangles, "patches": f.patches, "resident_patches": f.resident, "awaited_patches": f.pending,
                "gpu_bytes": f.gpu_bytes, "lifted_m": f.lifted_m, "settled": f.settled,
                "cracks": faults.cracks, "flipped": faults.flipped, "holes": faults.holes,
            })
        };
        Ok(json!({
            "patches_built": self.built, "built_per_s": self.rate(), "build_ms": self.build_ms(), "patches_read": self.read,
            "frames_until_settled": self.at_end.len(), "frame_ms": { "p50": median, "p95": p95, "max": worst },
            "gpu_bytes": self.bytes[0].0, "gpu_budget": self.bytes[0].1, "host_bytes": self.bytes[1].0, "host_budget": self.bytes[1].1,
            "allocated_bytes": self.allocated, "process_peak_bytes": process::peak_bytes(), "cracks": faults.cracks, "flipped": faults.flipped, "holes": faults.holes,
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
        }))
    }

    /// Fails if any frame was faulty.
    pub(super) fn verdict(&self) -> anyhow::Result<()> {
        let LiveFaults { cracks, flipped, holes } = self.faults();
        if cracks + flipped + holes > 0 {
            bail!("{cracks} cracks, {flipped} flipped triangles, {holes} lines of sight without ground");
        }
        Ok(())
    }
}
