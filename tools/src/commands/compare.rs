//! `terrane compare`: triangles at equal measured screen error, ours and those of classic methods.

use super::output::{check_output, Output};
use super::paths::GivenPath;
use super::viewing::{check_tolerance, picture_size};
use super::{pictures, Run};
use crate::compare::{best, count_probes, viewpoints, Effort, Equal, Measured, Setting, Viewpoint, FAMILIES};
use crate::Outcome;
use anyhow::Context as _;
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::time::Instant;
use terrane_planet::draw::view::Camera;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::planet::Planet;
use terrane_planet::store::PlanetFile;

/// Compare how many triangles different methods need for the same measured screen error. Needs no GPU.
///
/// Draws the frames of camera paths with our wake distances, a CDLOD quadtree of morphing grids, right-triangulated irregular networks
/// and cluster levels of detail; finds for each the knob with which its largest error over a path is as asked for, then the
/// one with which the 99.9th percentile over random pixels is; and counts triangles. Errors are radial distances from the finest
/// surface in the file, measured at the same points for all. A family's best variant counts.
#[derive(clap::Args)]
pub(crate) struct Compare {
    /// Planet file.
    file: PathBuf,
    /// Camera paths, as `terrane bench` takes them.
    #[arg(long, value_name = "PATH.json|NAME", value_delimiter = ',', default_value = "terra-descent,flyover")]
    path: Vec<PathBuf>,
    /// Frames of each path.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=1000))]
    frames: u32,
    /// Error in pixels that is made equal.
    #[arg(long, value_name = "PX", default_value_t = 1.0)]
    error: f64,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = picture_size)]
    size: [u32; 2],
    /// Random pixels of each frame at which errors are measured.
    #[arg(long, value_name = "N", default_value_t = 8192, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pixels: u32,
    /// Cells along a side of the blocks of finer patches, of each of which the sample where the ground bends most is measured.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=64))]
    block: u32,
    /// JSON file to write.
    #[arg(long, value_name = "OUT")]
    json: Option<PathBuf>,
}

/// What the best variant of a family showed on a path.
struct Row {
    path: String,
    equal: Equal,
    measured: Measured,
}

impl Run for Compare {
    fn run(self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        check_tolerance(self.error)?;
        if let Some(out) = &self.json {
            check_output("--json", out, Output::File(&[]))?;
        }
        let file = PlanetFile::open(&self.file)?;
        let planet = Planet::from_header(file.header())?;
        let tree = planet.tree(file.index()?.iter().filter(|r| r.has_mesh()).map(|r| (r.id, r.facts)));
        let setting = Setting::new(tree, Box::new(move |id| file.mesh(id)));
        let effort = Effort { pixels: self.pixels as usize, block: self.block as usize };
        let mut paths = Vec::new();
        for path in &self.path {
            let viewpoints = viewpoints(&setting, &self.cameras(&planet, path)?, self.error, effort)?;
            eprintln!(
                "{}: {} frames, {} probes, {:.0} s",
                path.display(),
                viewpoints.len(),
                count_probes(&viewpoints),
                seconds(begun)
            );
            paths.push((path.display().to_string(), viewpoints));
        }
        let rows = self.measure(&setting, &paths, begun)?;
        paths.iter().for_each(|(name, _)| print(name, &rows, self.error));
        if let Some(out) = &self.json {
            let text = serde_json::to_string_pretty(&self.report(&paths, &rows, begun))?;
            pictures::write_whole(out, text.as_bytes()).with_context(|| format!("cannot write the results {}", out.display()))?;
        }
        Ok(Outcome::Done)
    }
}

fn seconds(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64()
}

impl Compare {
    fn cameras(&self, planet: &Planet, path: &Path) -> anyhow::Result<Vec<Camera>> {
        let path = GivenPath::read(path)?.over(planet)?;
        let (first, last) = path.span();
        let step = (last - first) / f64::from(self.frames - 1);
        Ok((0..self.frames).map(|k| planet.camera_on(&path.at(first + step * f64::from(k)), self.size)).collect())
    }

    /// One family after the other, so that only one keeps what it makes of patches.
    fn measure(&self, setting: &Setting, paths: &[(String, Vec<Viewpoint>)], begun: Instant) -> anyhow::Result<Vec<Row>> {
        let mut rows = Vec::new();
        for family in FAMILIES {
            let methods = family(setting)?;
            for ((path, viewpoints), equal) in paths.iter().flat_map(|path| Equal::ALL.map(|equal| (path, equal))) {
                let mut progress = |m: &Measured| {
                    let (frames, name) = (m.in_view.len(), equal.name());
                    let found =
                        format!("{name} {:.3} px at {:.3}, {:.0} triangles in view", m.error(equal), m.knob, m.mean_in_view());
                    eprintln!("{:.0} s: {path}, {frames} frames, {} ({}): {found}", seconds(begun), m.family, m.variant);
                };
                let measured = best(setting, viewpoints, &methods, (equal, self.error), &mut progress)?;
                let measured = measured.with_context(|| format!("{path}: no knob brings every frame near {} px", self.error))?;
                rows.push(Row { path: path.clone(), equal, measured });
            }
        }
        Ok(rows)
    }

    fn report(&self, paths: &[(String, Vec<Viewpoint>)], rows: &[Row], begun: Instant) -> Value {
        let probes: serde_json::Map<_, _> =
            paths.iter().map(|(name, viewpoints)| (name.clone(), count_probes(viewpoints).into())).collect();
        json!({
            "planet": self.file, "frames": self.frames, "size": self.size, "target_px": self.error, "probes": probes,
            "commit": env!("TERRANE_COMMIT"), "version": env!("CARGO_PKG_VERSION"), "seconds": seconds(begun),
            "rows": rows.iter().map(|row| describe(row, rows)).collect::<Vec<_>>(),
        })
    }
}

/// Triangles of ours over those of a row.
fn share(row: &Row, rows: &[Row]) -> f64 {
    let ours = rows.iter().find(|r| r.path == row.path && r.equal == row.equal && r.measured.family == rows[0].measured.family);
    ours.map_or(f64::NAN, |ours| ours.measured.mean_in_view() / row.measured.mean_in_view())
}

fn describe(row: &Row, rows: &[Row]) -> Value {
    let m = &row.measured;
    let (frame, (latitude, longitude)) = (m.worst.0, latitude_longitude(m.worst.1));
    json!({
        "path": row.path, "equal": row.equal.name(), "method": m.family, "variant": m.variant, "knob": m.knob,
        "max_px": m.max, "p999_px": m.p999, "p50_px": m.p50, "missed": m.missed,
        "triangles_in_view": m.mean_in_view(), "triangles_submitted": m.submitted as f64 / m.in_view.len() as f64,
        "ours_over_this": share(row, rows), "in_view_by_frame": m.in_view, "max_px_by_frame": m.max_by_frame,
        "worst": { "frame": frame, "latitude": latitude, "longitude": longitude },
    })
}

fn print(path: &str, rows: &[Row], target: f64) {
    println!("{path}, equal errors of {target} px; triangles a frame");
    println!("| equal | method | knob | max px | p99.9 px | p50 px | in view | most in view | before culling | ours : this |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for row in rows.iter().filter(|row| row.path == path) {
        let m = &row.measured;
        let (most, submitted) = (m.in_view.iter().max().unwrap_or(&0), m.submitted / m.in_view.len().max(1));
        println!(
            "| {} | {}, {} | {:.3} | {:.3} | {:.3} | {:.3} | {:.0} | {most} | {submitted} | {:.3} |",
            row.equal.name(),
            m.family,
            m.variant,
            m.knob,
            m.max,
            m.p999,
            m.p50,
            m.mean_in_view(),
            share(row, rows)
        );
    }
    println!();
}
