//! `terrane raster`: heights or albedo of a place as GeoTIFF.

use super::building::{stop_on_signals, Report};
use super::height::{check_site, open_planet};
use super::output::{check_output, Output};
use super::viewing::numbers;
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{ensure, Context as _};
use rayon::prelude::*;
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;
use terrane_planet::export::raster::{albedo_file, albedo_rows, height_file, height_rows, GroundGrid};

/// Samples computed between two looks at signals.
const BATCH: u32 = 1 << 20;

/// Write the heights of a place, or its albedo, as a GeoTIFF for GIS. Needs no GPU.
///
/// Samples are points on a grid of latitude and longitude, square at the middle of the raster, on a sphere of the planet's radius, which
/// the file's keys describe. Heights (Float32) are metres above that sphere, without the sea; --albedo writes the ground's colour
/// (RGB, sRGB-encoded). Both are computed from the terrain itself.
#[derive(clap::Args)]
pub(crate) struct Raster {
    /// Planet file, or a recipe: a TOML file, or the name of one that comes with the command.
    file: PathBuf,
    /// Middle of the raster in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = numbers::<2>, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Samples from west to east and from north to south.
    #[arg(long, value_name = "WxH", value_parser = raster_size)]
    size: [u32; 2],
    /// Metres between samples at the middle.
    #[arg(long, value_name = "M")]
    spacing: f64,
    /// The ground's colour instead of its heights.
    #[arg(long)]
    albedo: bool,
    /// GeoTIFF to write.
    #[arg(long, value_name = "x.tif")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Parses a size such as 1024x512, of any sides.
fn raster_size(text: &str) -> Result<[u32; 2], String> {
    let sides: Option<Vec<u32>> = text.split(['x', 'X', '×']).map(|part| part.parse().ok()).collect();
    sides.and_then(|sides| <[u32; 2]>::try_from(sides).ok()).ok_or_else(|| format!("'{text}' is no size such as 1024x512"))
}

impl Run for Raster {
    fn run(self) -> anyhow::Result<Outcome> {
        check_output("--out", &self.out, Output::File(&["tif", "tiff"]))?;
        check_site(self.at)?;
        ensure!((1e-3..=1e6).contains(&self.spacing), "--spacing: found {}, expected 0.001 to 1000000 metres", self.spacing);
        let (planet, _) = open_planet(&self.file)?;
        let grid = GroundGrid::around(self.at, self.size, self.spacing, planet.recipe.radius)?;
        let bytes = if self.albedo {
            let rows = self.rows(&grid, &|row| albedo_rows(&planet, &grid, row..row + 1))?;
            rows.map(|rows| albedo_file(&planet, &grid, &rows)).transpose()?
        } else {
            let rows = self.rows(&grid, &|row| height_rows(&planet, &grid, row..row + 1))?;
            rows.map(|rows| height_file(&planet, &grid, &rows)).transpose()?
        };
        let Some(bytes) = bytes else {
            eprintln!("terrane: interrupted, nothing written");
            return Ok(Outcome::Interrupted);
        };
        pictures::write_whole(&self.out, &bytes).with_context(|| format!("cannot write the raster {}", self.out.display()))?;
        self.print(&grid, planet.recipe.radius, bytes.len());
        Ok(Outcome::Done)
    }
}

impl Raster {
    /// All rows, by batches on all processors; none if it was interrupted.
    fn rows<T: Send>(&self, grid: &GroundGrid, row: &(dyn Fn(u32) -> Vec<T> + Sync)) -> anyhow::Result<Option<Vec<T>>> {
        let (stop, begun) = (stop_on_signals()?, Instant::now());
        let report = Report::counting(&self.out.display().to_string(), "rows");
        let batch = (BATCH / grid.columns).max(1);
        let mut samples = Vec::new();
        for first in (0..grid.rows).step_by(batch as usize) {
            if stop.load(Ordering::Relaxed) {
                report.finish();
                return Ok(None);
            }
            let last = grid.rows.min(first + batch);
            let rows: Vec<Vec<T>> = (first..last).into_par_iter().map(row).collect();
            samples.extend(rows.into_iter().flatten());
            report.step(last as usize, grid.rows as usize, begun.elapsed());
        }
        report.finish();
        Ok(Some(samples))
    }

    fn print(&self, grid: &GroundGrid, radius: f64, bytes: usize) {
        let GroundGrid { columns, rows, west, north, step_east, step_south, .. } = *grid;
        let (east, south) = (west + f64::from(columns - 1) * step_east, north - f64::from(rows - 1) * step_south);
        if self.json {
            let summary = json!({
                "raster": self.out, "holds": if self.albedo { "albedo" } else { "heights" }, "columns": columns, "rows": rows,
                "bounds_deg": { "west": west, "south": south, "east": east, "north": north }, "spacing_m": self.spacing,
                "radius_m": radius, "bytes": bytes,
            });
            println!("{summary}");
            return;
        }
        let megabytes = bytes as f64 / 1e6;
        println!(
            "{}: {columns} x {rows} samples {} m apart, latitude {south:.5} to {north:.5}, longitude {west:.5} to {east:.5}, {megabytes:.1} MB",
            self.out.display(),
            self.spacing
        );
    }
}
