//! `terrane growth`: how the cost of the mesh stages grows with what is awake.

mod fit;
mod plot;

use super::drawing::DrawOptions;
use super::output::{check_output, Output};
use super::planets::PlanetPlace;
use super::viewing::{check_tolerance, CameraOptions, Exposure};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{ensure, Context as _};
use fit::{fit, Fit};
use serde_json::json;
use std::path::PathBuf;
use terrane::frame::Stage;
use terrane::headless::Headless;
use terrane::measure::{measure_frame, FrameCost};
use terrane_planet::draw::view::TOLERANCE_RANGE;

/// Draw one view at ever finer tolerances, and see how the times of selection, resolution and emission grow with the awake vertices.
///
/// Every tolerance is drawn several times; of each stage's times the least counts, since others use the machine too.
#[derive(clap::Args)]
pub(crate) struct Growth {
    /// Planet file.
    file: PathBuf,
    #[command(flatten)]
    camera: CameraOptions,
    /// Finest tolerance in pixels; the coarsest is --error.
    #[arg(long, value_name = "PX", default_value_t = 0.05)]
    finest: f64,
    /// Tolerances, in equal ratios.
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(3..=100))]
    steps: u32,
    /// Frames of each tolerance.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// SVG picture of the result to write.
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    draw: DrawOptions,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What one tolerance cost.
#[derive(Clone, Copy, Debug)]
struct Point {
    tolerance: f64,
    /// Counts, and the least of each time.
    cost: FrameCost,
    /// Milliseconds of each of [`Stage::MESH`].
    stages: [f64; Stage::MESH.len()],
}

impl Point {
    fn awake(&self) -> f64 {
        f64::from(self.cost.awake)
    }

    fn mesh_ms(&self) -> f64 {
        self.stages.iter().sum()
    }
}

impl Run for Growth {
    fn run(self) -> anyhow::Result<Outcome> {
        check_tolerance(self.camera.error())?;
        let least = TOLERANCE_RANGE.0;
        ensure!(
            (least..self.camera.error()).contains(&self.finest),
            "--finest: {} is not within {least} and less than --error, {}",
            self.finest,
            self.camera.error()
        );
        if let Some(out) = &self.plot {
            check_output("--plot", out, Output::File(&[]))?;
        }
        let (context, mut scene) = self.draw.open(&PlanetPlace::of_file(&self.file))?;
        let camera = self.camera.camera(scene.planet())?;
        let [width, height] = camera.size;
        let mut headless = Headless::new(&context, (width, height))?;
        let look = self.draw.look.look(&scene.planet().recipe, self.camera.site(&scene.planet().recipe)?, Exposure::Fixed(1.0));
        let mut points = Vec::new();
        for step in 0..self.steps {
            let along = f64::from(step) / f64::from(self.steps - 1);
            let tolerance = (self.camera.error().ln() * (1.0 - along) + self.finest.ln() * along).exp();
            let view = self.draw.view(camera, scene.planet(), tolerance);
            let costs = (0..self.repeats).map(|_| measure_frame(&mut scene, &mut headless, &view, &look));
            points.push(point(tolerance, &costs.collect::<Result<Vec<_>, _>>()?)?);
        }
        let sums: Vec<[f64; 2]> = points.iter().map(|p| [p.awake(), p.mesh_ms()]).collect();
        let fit = fit(&sums).context("--error and --finest: too few vertices change for a growth; take them farther apart")?;
        if let Some(out) = &self.plot {
            pictures::write_whole(out, plot::draw(&points, &fit).as_bytes())
                .with_context(|| format!("cannot write the plot {}", out.display()))?;
        }
        if self.json {
            println!("{}", summary(&points, &fit, &context.device_info().name));
        } else {
            print(&points, &fit);
        }
        self.draw.gpu.report_messages(&context)?;
        Ok(Outcome::Done)
    }
}

/// The least times of some frames of one tolerance.
fn point(tolerance: f64, costs: &[FrameCost]) -> anyhow::Result<Point> {
    let mut stages = [f64::INFINITY; Stage::MESH.len()];
    let mut cost = *costs.first().context("no frames")?;
    for frame in costs {
        for (least, stage) in stages.iter_mut().zip(Stage::MESH) {
            *least = least.min(frame.stages_ms[stage].context("this GPU measures no times")?);
        }
        cost.frame_ms = cost.frame_ms.min(frame.frame_ms);
    }
    Ok(Point { tolerance, cost, stages })
}

fn print(points: &[Point], fit: &Fit) {
    let [a, b, c] = Stage::MESH.map(|stage| format!("{} ms", stage.name()));
    println!(
        "{:>9} {:>10} {:>10} {:>11} {:>10} {a:>10} {b:>10} {c:>10} {:>9}",
        "error px", "awake", "prefix", "candidates", "drawn", "ns/awake"
    );
    for p in points {
        let FrameCost { awake, prefix_vertices, candidate_triangles, triangles, .. } = p.cost;
        let [a, b, c] = p.stages;
        let each = 1e6 * p.mesh_ms() / p.awake();
        println!(
            "{:>9.3} {awake:>10} {prefix_vertices:>10} {candidate_triangles:>11} {triangles:>10} {a:>10.3} {b:>10.3} {c:>10.3} {each:>9.1}",
            p.tolerance
        );
    }
    println!(
        "over a factor of {:.0} in awake vertices the three stages together take {:.3} ms + {:.1} ns for each",
        fit.factor,
        fit.constant_ms,
        1e6 * fit.ms_each
    );
    println!("largest deviation {:.1} %; exponent {:.3} (1 is linear)", 100.0 * fit.deviation, fit.exponent);
}

fn summary(points: &[Point], fit: &Fit, device: &str) -> serde_json::Value {
    let row = |p: &Point| {
        let mut row = json!({
            "tolerance_px": p.tolerance, "awake_vertices": p.cost.awake, "prefix_vertices": p.cost.prefix_vertices,
            "candidate_triangles": p.cost.candidate_triangles, "triangles": p.cost.triangles,
            "frame_ms": p.cost.frame_ms,
        });
        for (stage, ms) in Stage::MESH.iter().zip(p.stages) {
            row[format!("{}_ms", stage.name())] = json!(ms);
        }
        row
    };
    json!({
        "device": device, "rows": points.iter().map(row).collect::<Vec<_>>(), "factor": fit.factor,
        "constant_ms": fit.constant_ms, "ns_each": 1e6 * fit.ms_each, "largest_deviation": fit.deviation, "exponent": fit.exponent,
    })
}
