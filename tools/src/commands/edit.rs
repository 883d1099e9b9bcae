//! `terrane edit`: changes the ground of a planet file, or undoes a change. Only the patches that can tell the difference are built
//! again.

use super::building::{stop_on_signals, Report, Threads};
use super::viewing::numbers;
use super::Run;
use crate::Outcome;
use anyhow::Context;
use serde_json::{json, Value};
use std::path::PathBuf;
use std::time::Instant;
use terrane_planet::planet::edits::{add, finish, mean_height, undo, Changed};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit as GroundEdit, Shape};
use terrane_planet::store::PlanetFile;

/// Change the ground of a planet file, and build again only what the change touches.
#[derive(clap::Args)]
pub(crate) struct Edit {
    /// Planet file.
    file: PathBuf,
    #[command(subcommand)]
    action: Action,
    #[command(flatten)]
    threads: Threads,
    /// Print one JSON object.
    #[arg(long, global = true)]
    json: bool,
}

/// Where an edit lies.
#[derive(clap::Args, Clone, Copy)]
struct Area {
    /// Latitude and longitude of the middle, in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = numbers::<2>, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Radius on the ground, in metres (0.1 to a third of the planet's).
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    radius: f64,
}

#[derive(clap::Subcommand, Clone, Copy)]
enum Action {
    /// An impact crater: bowl, raised rim, and ejecta out to three radii.
    Crater {
        #[command(flatten)]
        area: Area,
        /// Metres of the floor below the ground before; the rim rises by a quarter of that.
        #[arg(long, value_name = "M", allow_hyphen_values = true)]
        depth: f64,
    },
    /// A level site with a smooth shoulder.
    Flatten {
        #[command(flatten)]
        area: Area,
        /// Metres above the datum [default: the mean of the ground there].
        #[arg(long, value_name = "M", allow_hyphen_values = true)]
        height: Option<f64>,
    },
    /// A mound; a hollow, if by a negative height.
    Raise {
        #[command(flatten)]
        area: Area,
        /// Metres in the middle.
        #[arg(long, value_name = "M", allow_hyphen_values = true)]
        by: f64,
    },
    /// List the edits, the first one first.
    List,
    /// Take the last edit away again.
    Undo,
    /// Build what an interrupted edit has left to build.
    Resume,
}

/// An edit as `--json` prints it.
pub(crate) fn edit_json(edit: &GroundEdit) -> Value {
    let numbers = edit.numbers().into_iter().map(|(key, value)| (key.to_owned(), value.into()));
    [("kind".to_owned(), edit.shape.name().into())].into_iter().chain(numbers).collect::<serde_json::Map<_, _>>().into()
}

impl Area {
    fn edit(self, shape: Shape) -> GroundEdit {
        let [latitude_deg, longitude] = self.at;
        let turns = if (180.0..=360.0).contains(&longitude.abs()) { longitude.signum() } else { 0.0 };
        GroundEdit { latitude_deg, longitude_deg: longitude - 360.0 * turns, radius_m: self.radius, shape }
    }

    /// Mean height of the ground there, once there is known to be a site on the planet.
    fn mean_height(self, planet: &Planet) -> anyhow::Result<f64> {
        let edit = self.edit(Shape::Raise { by_m: 0.0 });
        edit.check(planet.recipe.radius)?;
        Ok(mean_height(planet, edit.latitude_deg, edit.longitude_deg, edit.radius_m))
    }
}

impl Run for Edit {
    fn run(self) -> anyhow::Result<Outcome> {
        if matches!(self.action, Action::List) {
            return self.list();
        }
        let start = Instant::now();
        let mut file = PlanetFile::open_to_edit(&self.file)?;
        let planet = Planet::from_header(file.header())?;
        let changed = self.change(&mut file, &planet)?;
        let (planet, edit, touched, faces) = match changed {
            Some(Changed { planet, edit, touched, faces, .. }) => (planet, Some(edit), touched, faces),
            None => (planet, None, 0, 0),
        };
        let (stop, report) = (stop_on_signals()?, Report::new(&planet.recipe.name));
        let summary = finish(&mut file, &planet, self.threads.count(), &|p| report.show(p), &stop);
        report.finish();
        let summary = summary.with_context(|| format!("{}: unfinished, {}", self.file.display(), self.how_to_resume()))?;
        let (rebuilt, seconds) = (faces + summary.built, start.elapsed().as_secs_f64());
        let bytes = std::fs::metadata(&self.file).map_or(0, |data| data.len());
        if self.json {
            println!(
                "{}",
                json!({
                    "file": self.file.display().to_string(), "action": self.name(), "edit": edit.as_ref().map(edit_json),
                    "edits": planet.recipe.edits.len(), "patches_touched": touched, "patches_rebuilt": rebuilt,
                    "pending": file.pending()?.len(), "interrupted": summary.interrupted, "seconds": seconds,
                    "geometry_bytes": summary.geometry_bytes, "texture_bytes": summary.texture_bytes, "file_bytes": bytes,
                })
            );
        } else {
            let what = edit.map_or_else(|| "finished".to_owned(), |edit| edit.to_string());
            let undone = if matches!(self.action, Action::Undo) { "undone: " } else { "" };
            println!("{}: {undone}{what}", self.file.display());
            println!("{touched} patches touched, {rebuilt} built again, {seconds:.1} s");
            if summary.interrupted {
                println!("interrupted: {}", self.how_to_resume());
            }
        }
        Ok(if summary.interrupted { Outcome::Interrupted } else { Outcome::Done })
    }
}

impl Edit {
    /// Makes or undoes an edit, up to the patches that are left to build.
    fn change(&self, file: &mut PlanetFile, planet: &Planet) -> anyhow::Result<Option<Changed>> {
        let edit = match self.action {
            Action::List | Action::Resume => return Ok(None),
            Action::Undo => return Ok(Some(undo(file, planet)?)),
            Action::Raise { area, by } => area.edit(Shape::Raise { by_m: by }),
            Action::Flatten { area, height: Some(height) } => area.edit(Shape::Flatten { height_m: height }),
            Action::Flatten { area, height: None } => area.edit(Shape::Flatten { height_m: area.mean_height(planet)? }),
            Action::Crater { area, depth } => {
                area.edit(Shape::Crater { depth_m: depth, ground_m: Some(area.mean_height(planet)?) })
            }
        };
        Ok(Some(add(file, planet, edit)?))
    }

    fn list(&self) -> anyhow::Result<Outcome> {
        let file = PlanetFile::open(&self.file)?;
        let (planet, pending) = (Planet::from_header(file.header())?, file.pending()?.len());
        let edits = &planet.recipe.edits;
        if self.json {
            let edits: Vec<Value> = edits.iter().map(edit_json).collect();
            println!("{}", json!({ "file": self.file.display().to_string(), "edits": edits, "pending": pending }));
            return Ok(Outcome::Done);
        }
        for (k, edit) in edits.iter().enumerate() {
            println!("{}: {edit}", k + 1);
        }
        if edits.is_empty() {
            println!("{}: no edits", self.file.display());
        }
        if pending > 0 {
            println!("unfinished: {pending} patches to build again; {}", self.how_to_resume());
        }
        Ok(Outcome::Done)
    }

    fn how_to_resume(&self) -> String {
        format!("'terrane edit {} resume' goes on from here", self.file.display())
    }

    fn name(&self) -> &'static str {
        match self.action {
            Action::Crater { .. } => "crater",
            Action::Flatten { .. } => "flatten",
            Action::Raise { .. } => "raise",
            Action::List => "list",
            Action::Undo => "undo",
            Action::Resume => "resume",
        }
    }
}
