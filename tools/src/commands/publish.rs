//! `terrane publish`: a planet as a folder for any static host.

use super::building::{stop_on_signals, Report};
use super::output::{check_output, Output};
use super::planets::built_planet_file;
use super::Run;
use crate::Outcome;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use terrane_planet::published::{publish, PublishError, MANIFEST};
use terrane_planet::store::PlanetFile;

/// Lay a planet out in a folder for any static host: other machines then draw it from the address of its planet.json. Needs no GPU.
///
/// All that the planet file holds is published: meshes in chunks, each of which is decoded with those before it, and textures. Every file but
/// planet.json is named by what it holds and never changes, so that it can be cached for ever; servers need nothing but byte ranges.
/// Published again, after an edit or a deeper bake, only what changed is written.
#[derive(clap::Args)]
pub(crate) struct Publish {
    /// Planet file; or a recipe or the name of one, whose coarsest two levels are built.
    #[arg(value_name = "FILE|RECIPE|NAME")]
    file: PathBuf,
    /// Folder to publish in; made if need be.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Remove files that nothing names any more. Readers that began before may still want them.
    #[arg(long)]
    remove_old: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Publish {
    fn run(self) -> anyhow::Result<Outcome> {
        check_output("--out", &self.out, Output::Folder)?;
        let place = built_planet_file(Some(&self.file), None)?;
        let file = PlanetFile::open(place.path())?;
        let (stop, begun) = (stop_on_signals()?, Instant::now());
        let name = file.header().name.clone();
        let report = Report::new(&name);
        let done = publish(&file, &self.out, self.remove_old, &|done, total| report.step(done, total, begun.elapsed()), &stop);
        report.finish();
        let done = match done {
            Err(error @ PublishError::Stopped) => {
                eprintln!("terrane: {error}");
                return Ok(Outcome::Interrupted);
            }
            other => other?,
        };
        let (manifest, seconds) = (self.out.join(MANIFEST), begun.elapsed().as_secs_f64());
        if self.json {
            let summary = json!({
                "manifest": manifest, "name": name, "patches": done.patches, "bytes": done.bytes, "written": done.written,
                "written_bytes": done.written_bytes, "kept": done.kept, "removed": done.removed, "seconds": seconds,
            });
            println!("{summary}");
        } else {
            println!(
                "{}: {name}, {} patches, {:.1} MB; {} files written ({:.1} MB), {} kept, {} removed, {seconds:.1} s",
                manifest.display(),
                done.patches,
                done.bytes as f64 / 1e6,
                done.written,
                done.written_bytes as f64 / 1e6,
                done.kept,
                done.removed
            );
        }
        Ok(Outcome::Done)
    }
}
