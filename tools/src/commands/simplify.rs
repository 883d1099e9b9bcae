//! `terrane simplify`: a heightfield file as meshes of so many triangles, or of so small an error.

use super::exporting::ExportOptions;
use super::output::{check_output, Output};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, ensure, Context as _};
use glam::DVec3;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;
use terrane_heightfield::classic::{Cost, Level, Levels};
use terrane_heightfield::import;
use terrane_heightfield::import::Imported;
use terrane_heightfield::Heightfield;
use terrane_planet::export::{Format, Model, Picture, EXTENSIONS};

/// Metres between samples of a file that does not say.
const DEFAULT_SPACING_M: f64 = 1.0;

/// What chooses the vertices that go first.
#[derive(clap::ValueEnum, Clone, Copy)]
enum CostOption {
    /// The error measured at every sample.
    Certified,
    /// Quadric error metrics (Garland and Heckbert 1997).
    Quadric,
    /// Anchor springs (after Sklyar).
    Spring,
}

/// Turn a heightfield (PNG, TIFF or GeoTIFF, SRTM .hgt, Terragen .raw) into triangle meshes. Needs no GPU.
///
/// Meshes hold metres: +X east, +Y north (the first row of the file is north), +Z up, from the south-west sample; OBJ and GLB are turned
/// to Y up (see --up). Normals are those of the heights. Errors are vertical, in metres, and measured at every sample of the file. Samples without data are filled from
/// their surroundings first. Several levels become several files: x.ply with --faces 1000,100 is written as x-1000.ply and
/// x-100.ply, with --error 2,8 as x-e2.ply and x-e8.ply.
#[derive(clap::Args)]
pub(crate) struct Simplify {
    /// Heightfield file.
    file: PathBuf,
    /// Most triangles of each mesh.
    #[arg(long, value_name = "N,…", value_delimiter = ',', required_unless_present = "error", conflicts_with = "error")]
    faces: Vec<usize>,
    /// Largest error of each mesh in metres: as few triangles as that takes.
    #[arg(long, value_name = "E,…", value_delimiter = ',')]
    error: Vec<f64>,
    /// What chooses the vertices that go first. The two classics are there to compare with: they take about 30 µs and 700 bytes a
    /// sample, certified a tenth of the time and a quarter of the memory.
    #[arg(long, value_enum, default_value = "certified")]
    cost: CostOption,
    /// Keep vertices at the heights of their samples. Without this, certified surfaces are polished: heights are fitted and edges
    /// flipped, which lowers the largest error by a quarter to a third at the same number of triangles.
    #[arg(long)]
    keep_samples: bool,
    /// Metres between samples [default: what the file says, else 1].
    #[arg(long, value_name = "M")]
    spacing: Option<f64>,
    /// Metres a unit of height in the file.
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    height_scale: f64,
    #[command(flatten)]
    export: ExportOptions,
    /// Picture of the same ground, a PNG or JPEG with north up, to put into the GLB as it is; its corners lie on the corner samples.
    #[arg(long, value_name = "x.png|x.jpg", conflicts_with = "solid")]
    texture: Option<PathBuf>,
    #[arg(long, help = format!("File to write: {EXTENSIONS}"))]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// One mesh to make.
#[derive(Clone, Copy)]
enum Goal {
    Faces(usize),
    Error(f64),
}

impl Run for Simplify {
    fn run(self) -> anyhow::Result<Outcome> {
        let format = Format::of(&self.out)?;
        self.export.check(format)?;
        let picture = self.picture(format)?;
        let goals = self.goals()?;
        for &goal in &goals {
            check_output("--out", &self.path(goal, goals.len() > 1), Output::File(&[]))?;
        }
        let mut image = import::load(&self.file)?;
        let scale = self.scale(&image)?;
        let filled = image.field.fill_gaps();
        if filled > 0 {
            eprintln!(
                "terrane: filled {filled} of {} samples, which hold no data, from their surroundings",
                image.field.heights().len()
            );
        }
        let begun = Instant::now();
        let mut levels = simplified(&image.field, self.cost.cost())?;
        if !self.keep_samples {
            levels = levels.with_polish();
        }
        let seconds = begun.elapsed().as_secs_f64();
        let mut rows = Vec::new();
        for &goal in &goals {
            let level = match goal {
                Goal::Faces(faces) => levels.of_faces(faces),
                Goal::Error(metres) => levels.of_error(metres / scale.z),
            };
            rows.push(self.write_level(&level, &image.field, picture.clone(), &self.path(goal, goals.len() > 1), scale)?);
        }
        if self.json {
            println!("{}", self.summary(&image, scale, filled, seconds, rows));
        }
        Ok(Outcome::Done)
    }
}

impl CostOption {
    fn cost(self) -> Cost {
        match self {
            CostOption::Certified => Cost::Certified,
            CostOption::Quadric => Cost::Quadric,
            CostOption::Spring => Cost::Spring,
        }
    }
}

/// All levels of a field; says so on stderr, since it can take minutes.
fn simplified(field: &Heightfield, cost: Cost) -> anyhow::Result<Levels<'_>> {
    let collapses = (field.heights().len() - 4) as u64;
    eprintln!("terrane: simplifying {} x {} samples by {} cost", field.columns(), field.rows(), cost.name());
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(collapses) } else { ProgressBar::hidden() };
    bar.set_style(ProgressStyle::with_template("{bar:40} {percent}% {eta}")?);
    let levels = Levels::new(field, cost, &mut |done| bar.set_position(done as u64))?;
    bar.finish_and_clear();
    Ok(levels)
}

impl Simplify {
    fn goals(&self) -> anyhow::Result<Vec<Goal>> {
        for &faces in &self.faces {
            ensure!(faces >= 2, "--faces: found {faces}, expected 2 or more: a rectangle has no fewer triangles");
        }
        for &error in &self.error {
            ensure!(error >= 0.0 && error.is_finite(), "--error: found {error}, expected 0 or more metres");
        }
        let faces = self.faces.iter().map(|&faces| Goal::Faces(faces));
        let goals: Vec<Goal> = faces.chain(self.error.iter().map(|&error| Goal::Error(error))).collect();
        let mut names: Vec<PathBuf> = goals.iter().map(|&goal| self.path(goal, true)).collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            bail!("two levels would both be written to {}; ask for each level once", twice[0].display());
        }
        Ok(goals)
    }

    /// Metres a sample spacing east and north, and a unit of height.
    fn scale(&self, image: &Imported) -> anyhow::Result<DVec3> {
        let [across, along] = match (self.spacing, image.spacing_m) {
            (Some(metres), _) => {
                ensure!((1e-6..=1e6).contains(&metres), "--spacing: found {metres}, expected 0.000001 to 1000000 metres");
                [metres; 2]
            }
            (None, Some(own)) => own,
            (None, None) => [DEFAULT_SPACING_M; 2],
        };
        let height = self.height_scale;
        ensure!((1e-6..=1e6).contains(&height), "--height-scale: found {height}, expected 0.000001 to 1000000 metres");
        Ok(DVec3::new(across, along, height))
    }

    /// The file of a level.
    fn path(&self, goal: Goal, several: bool) -> PathBuf {
        let [stem, extension] =
            [self.out.file_stem(), self.out.extension()].map(|part| part.unwrap_or_default().to_string_lossy());
        match goal {
            _ if !several => self.out.clone(),
            Goal::Faces(faces) => self.out.with_file_name(format!("{stem}-{faces}.{extension}")),
            Goal::Error(error) => self.out.with_file_name(format!("{stem}-e{error}.{extension}")),
        }
    }

    /// The picture of `--texture`.
    fn picture(&self, format: Format) -> anyhow::Result<Option<Picture>> {
        let Some(path) = &self.texture else { return Ok(None) };
        ensure!(format == Format::Glb, "--texture: {} files hold no picture; write a .glb or leave it out", format.name());
        let bytes = std::fs::read(path).with_context(|| format!("--texture: cannot read {}", path.display()))?;
        let picture = Picture::of_file(bytes);
        Ok(Some(picture.with_context(|| format!("--texture: {} is neither a PNG nor a JPEG; convert it", path.display()))?))
    }

    fn write_level(
        &self,
        level: &Level,
        field: &Heightfield,
        picture: Option<Picture>,
        path: &Path,
        scale: DVec3,
    ) -> anyhow::Result<serde_json::Value> {
        let begun = Instant::now();
        let Level { surface, deviation } = level;
        let format = Format::of(path)?;
        let model = Model::of_heightfield(surface, field, scale);
        let model = match self.export.solid {
            Some(below) => model.solid(below),
            None => model,
        };
        let model = match picture {
            Some(picture) => model.with_picture(surface, [field.columns(), field.rows()], picture),
            None => model,
        };
        let (volume, written) = (self.export.solid.map(|_| model.volume()), model.triangle_count());
        let bytes = self.export.encode(model, format)?;
        pictures::write_whole(path, &bytes).with_context(|| format!("cannot write the mesh {}", path.display()))?;
        let (faces, vertices) = (surface.faces.len(), surface.positions.len());
        let (max, rms) = (deviation.max * scale.z, deviation.rms * scale.z);
        let seconds = begun.elapsed().as_secs_f64();
        if !self.json {
            let megabytes = bytes.len() as f64 / 1e6;
            println!(
                "{}: {faces} triangles, {vertices} vertices, error up to {max:.3} m, {rms:.3} m rms, {megabytes:.1} MB",
                path.display()
            );
        }
        Ok(json!({
            "faces": faces, "vertices": vertices, "max_error": max, "rms_error": rms, "uncovered": deviation.uncovered,
            "seconds": seconds, "file": path, "bytes": bytes.len(),
            "up": self.export.up_name(format)?, "volume_m3": volume, "triangles_in_file": written,
        }))
    }

    fn summary(
        &self,
        image: &Imported,
        scale: DVec3,
        filled: usize,
        seconds: f64,
        levels: Vec<serde_json::Value>,
    ) -> serde_json::Value {
        let bounds = image.grid.map(|grid| {
            let (south, east) = (grid.south(image.field.rows()), grid.east(image.field.columns()));
            json!({ "west": grid.west, "south": south, "east": east, "north": grid.north })
        });
        json!({
            "heightfield": self.file, "format": image.format.name(), "columns": image.field.columns(), "rows": image.field.rows(),
            "range": image.range, "bounds_deg": bounds, "spacing_m": [scale.x, scale.y], "height_scale_m": scale.z,
            "filled": filled, "cost": self.cost.cost().name(),
            "polished": !self.keep_samples && self.cost.cost() == Cost::Certified, "simplify_seconds": seconds, "levels": levels,
        })
    }
}
