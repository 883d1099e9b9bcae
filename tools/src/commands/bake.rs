//! `terrane bake`: builds the patches of a recipe into a planet file, or what is missing of them.

use super::building::{stop_on_signals, Report, Threads};
use super::output::{check_output, Output};
use super::recipes::load_recipe;
use super::region::RegionOptions;
use super::Run;
use crate::Outcome;
use anyhow::Context;
use serde_json::json;
use std::path::PathBuf;
use terrane_planet::maps::clouds::CLOUD_SIDE;
use terrane_planet::mesh::builder::Faults;
use terrane_planet::planet::bake::{bake, BakePlan, BakeSummary};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::{is_planet_file, PlanetFile, Records};

/// Build the patches of a recipe into a planet file; go on where an earlier bake stopped.
#[derive(clap::Args)]
pub(crate) struct Bake {
    /// Recipe of the planet: a TOML file, or `terra`, `luna`, `mars`, `earth`, `jacksboro` or `tiny`, which come with the command; or a planet
    /// file, to bake more of its planet with all edits.
    recipe: PathBuf,
    /// Planet file to make or to go on with.
    #[arg(long, short)]
    out: PathBuf,
    /// Finest level of the whole planet; 0 is the six cube faces.
    #[arg(long, short)]
    levels: u8,
    #[command(flatten)]
    region: RegionOptions,
    /// Grid cells along a patch side, a power of two.
    #[arg(long, default_value_t = 64)]
    cells: u32,
    #[command(flatten)]
    threads: Threads,
    /// Print the summary as one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Bake {
    fn run(self) -> anyhow::Result<Outcome> {
        check_output("--out", &self.out, Output::File(&[]))?;
        let planet = Planet::from_recipe(self.recipe()?, self.cells)?;
        let plan = BakePlan::new(planet.recipe.radius, self.levels, self.region.region())?;
        let mut file = PlanetFile::create_or_resume(&self.out, &planet.header())?;
        let stop = stop_on_signals()?;
        let report = Report::new(&planet.recipe.name);
        let summary = bake(&mut file, &planet.terrain, &planet.terrain, &plan, self.threads.count(), &|p| report.show(p), &stop);
        report.finish();
        let summary = summary.with_context(|| format!("cannot bake {} into {}", self.recipe.display(), self.out.display()))?;
        if let Some((clouds, true)) = planet.clouds([&file as &dyn Records]).filter(|_| !summary.interrupted) {
            file.keep_cloud_map(&clouds, CLOUD_SIDE)?;
        }
        self.print(&summary);
        Ok(if summary.interrupted { Outcome::Interrupted } else { Outcome::Done })
    }
}

impl Bake {
    fn recipe(&self) -> anyhow::Result<Recipe> {
        if !is_planet_file(&self.recipe) {
            return load_recipe(&self.recipe);
        }
        let file = PlanetFile::open(&self.recipe)?;
        let header = file.header();
        Ok(Recipe::from_parts(&header.recipe, &header.name, header.assets.clone())?)
    }

    fn print(&self, s: &BakeSummary) {
        let (seconds, rate, bytes) = (s.elapsed.as_secs_f64(), s.vertices_per_second(), s.bytes_per_vertex());
        let always = s.always_awake as f64 / s.built.max(1) as f64;
        if self.json {
            let summary = json!({
                "file": self.out.display().to_string(), "planned": s.planned, "built": s.built, "skipped": s.skipped,
                "interrupted": s.interrupted, "vertices": s.vertices, "seconds": seconds, "vertices_per_second": rate,
                "geometry_bytes": s.geometry_bytes, "bytes_per_vertex": bytes, "texture_bytes": s.texture_bytes,
                "always_awake_per_patch": always, "stuck_border": s.faults.stuck_border,
                "stuck_interior": s.faults.stuck_interior, "uncertified": s.faults.uncertified,
            });
            println!("{summary}");
            return;
        }
        let (out, left) = (self.out.display(), s.planned - s.built - s.skipped);
        println!("{out}: {} patches built, {} there before, {left} left", s.built, s.skipped);
        if s.built > 0 {
            println!("{:.1} s, {} vertices, {rate:.0} vertices/s", seconds, s.vertices);
            let megabytes = |b: u64| b as f64 / 1e6;
            println!(
                "geometry {:.1} MB ({bytes:.2} bytes a vertex), texture {:.1} MB",
                megabytes(s.geometry_bytes),
                megabytes(s.texture_bytes)
            );
            println!("{always:.1} vertices a patch always awake");
        }
        if s.faults != Faults::default() {
            println!("the builder broke its own rules: {:?}; the file is usable, please report this with the recipe", s.faults);
        }
        if s.interrupted {
            println!("interrupted: the same command goes on from here");
        }
    }
}
