//! `terrane study`: the classic comparison of simplification costs.

use super::output::{check_output, Output};
use super::{pictures, Run};
use crate::study::{arrival, plot, repeat, sheet, terrain::study_field, Series};
use crate::Outcome;
use anyhow::Context as _;
use serde_json::json;
use std::path::PathBuf;

/// Samples along each side of the study's heightfield.
const SIDE: usize = 40;

/// Compare the classic costs of mesh simplification on a small heightfield. Needs no GPU.
///
/// Coarsens 40 x 40 samples with every cost, measures the vertical error of each mesh at all of them, and writes a picture of the
/// meshes (meshes.png) and a plot of their errors (errors.svg). Heights and errors are in sample spacings. A third picture (arrival.png)
/// shows a patch of a planet as it arrives over a network.
#[derive(clap::Args)]
pub(crate) struct Study {
    /// Folder for the pictures, made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "docs/study")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Study {
    fn run(self) -> anyhow::Result<Outcome> {
        let field = study_field(SIDE);
        let all = repeat(&field)?;
        check_output("--out", &self.out, Output::Folder)?;
        let (meshes, errors) = (self.out.join("meshes.png"), self.out.join("errors.svg"));
        let canvas = sheet::draw(&field, &all);
        let size = canvas.size.map(|s| s as u32);
        let cannot = |path: &PathBuf| format!("cannot write {}", path.display());
        pictures::write_png(&meshes, size, &canvas.into_rgba(), None).with_context(|| cannot(&meshes))?;
        pictures::write_whole(&errors, plot::draw(&all).as_bytes()).with_context(|| cannot(&errors))?;
        let (patch, moments) = arrival::arrive()?;
        let (arriving, canvas) = (self.out.join("arrival.png"), arrival::draw(&patch, &moments));
        let size = canvas.size.map(|s| s as u32);
        pictures::write_png(&arriving, size, &canvas.into_rgba(), None).with_context(|| cannot(&arriving))?;
        if self.json {
            println!(
                "{}",
                json!({ "samples": [SIDE, SIDE], "meshes": meshes, "errors": errors, "table": table(&all), "arrival": arrival_json(&moments) })
            );
        } else {
            print(&all);
            println!("\nmeshes: {}\nerrors: {}", meshes.display(), errors.display());
        }
        Ok(Outcome::Done)
    }
}

fn table(all: &[Series]) -> Vec<serde_json::Value> {
    let rows = all.iter().flat_map(|series| series.pictured.iter().map(|sample| (series.cost, sample)));
    rows.map(|(cost, sample)| {
        json!({
            "cost": cost.name(), "asked": sample.asked, "faces": sample.surface.faces.len(),
            "max": sample.deviation.max, "rms": sample.deviation.rms, "uncovered": sample.deviation.uncovered,
        })
    })
    .collect()
}

fn print(all: &[Series]) {
    println!("{:<10} {:>6} {:>10} {:>10}", "cost", "faces", "max", "rms");
    for series in all {
        for sample in &series.pictured {
            let (faces, error) = (sample.surface.faces.len(), sample.deviation);
            println!("{:<10} {faces:>6} {:>10.6} {:>10.6}", series.cost.name(), error.max, error.rms);
        }
    }
}

/// What there is of the patch after each chunk.
fn arrival_json(moments: &[arrival::Moment]) -> Vec<serde_json::Value> {
    let moment = |m: &arrival::Moment| json!({ "bytes": m.bytes, "of": m.of, "vertices": m.vertices, "triangles": m.triangles, "largest_error_m": m.error_m });
    moments.iter().map(moment).collect()
}
