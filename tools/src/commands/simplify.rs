//! `terrane simplify`: a heightfield file as meshes of so many triangles, or of so small an error.

mod input;

use super::exporting::{write_sidecar, ExportOptions};
use super::output::{check_output, Output};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, ensure, Context as _};
use glam::DVec3;
use indicatif::{ProgressBar, ProgressStyle};
use input::{Gaps, Input};
use serde_json::{json, Value};
use std::io::{IsTerminal, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;
use terrane_heightfield::classic::{Cost, Level, Levels};
use terrane_heightfield::{Heightfield, Holes, TriangleSurface};
use terrane_planet::export::{Format, Model, Origin, Picture, EXTENSIONS};

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

/// Turn heightfields (GeoTIFF, SRTM .hgt, Esri .asc, PNG, .raw, and more) into triangle meshes. Needs no GPU.
///
/// Meshes hold metres: +X east, +Y north (the first row of the file is north), +Z up, from the south-west sample; OBJ and GLB are turned
/// to Y up (see --up). Normals are those of the heights. Errors are vertical, in metres, and measured at every sample of the file. Samples without data are filled from
/// their surroundings first, or cut out (--gaps cut). What is assumed about a file is said on stderr and in --json. Several levels
/// become several files: x.ply with --faces 1000,100 is written as x-1000.ply and x-100.ply, with --error 2,8 as x-e2.ply and
/// x-e8.ply.
#[derive(clap::Args)]
pub(crate) struct Simplify {
    #[command(flatten)]
    input: Input,
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
    #[command(flatten)]
    export: ExportOptions,
    /// Picture of the same ground, a PNG or JPEG with north up, to put into the GLB as it is; its corners lie on the corner samples.
    #[arg(long, value_name = "x.png|x.jpg", conflicts_with = "solid")]
    texture: Option<PathBuf>,
    #[arg(long, help = format!("File to write: {EXTENSIONS}; - for stdout, with --format"))]
    out: PathBuf,
    #[arg(long, help = format!("Format of stdout: {EXTENSIONS}"))]
    format: Option<String>,
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

/// What all levels are meshes of.
struct Ground<'a> {
    field: &'a Heightfield,
    /// Metres a sample spacing east and north, and a unit of height.
    scale: DVec3,
    origin: Option<Origin>,
    picture: Option<Picture>,
}

impl Run for Simplify {
    fn run(self) -> anyhow::Result<Outcome> {
        let format = self.mesh_format()?;
        self.export.check(format)?;
        let picture = self.picture(format)?;
        let goals = self.goals()?;
        for &goal in goals.iter().filter(|_| !self.to_stdout()) {
            let path = self.path(goal, goals.len() > 1);
            check_output("--out", &path, Output::File(&[]))?;
            self.export.check_sidecar(&path, &self.input.files)?;
        }
        let cuts = self.input.gaps == Gaps::Cut;
        ensure!(
            !cuts || self.export.solid.is_none(),
            "--solid: found --gaps cut, expected a surface without holes; leave one of them out"
        );
        ensure!(
            !cuts || self.cost.cost() == Cost::Certified,
            "--gaps cut: found --cost {}, expected certified",
            self.cost.cost().name()
        );
        let mut read = self.input.read(self.cost.bytes_a_sample())?;
        let (described, origin) = (read.described(), read.origin());
        let (image, scale) = (&mut read.image, read.scale);
        let holes = Holes::of(&image.field).filter(|_| self.input.gaps == Gaps::Cut);
        let samples = image.field.heights().len();
        let mut filled = image.field.fill_gaps();
        match &holes {
            Some(holes) => {
                eprintln!("terrane: {} of {samples} samples hold no data, and become holes", holes.count());
                filled = 0;
            }
            None if filled > 0 => {
                eprintln!("terrane: filled {filled} of {samples} samples, which hold no data, from their surroundings");
            }
            None => (),
        }
        let begun = Instant::now();
        let mut levels = simplified(&image.field, holes, self.cost.cost())?;
        if !self.keep_samples {
            levels = levels.with_polish();
        }
        let seconds = begun.elapsed().as_secs_f64();
        let ground = Ground { field: &image.field, scale, origin, picture };
        let mut rows = Vec::new();
        for &goal in &goals {
            let level = match goal {
                Goal::Faces(faces) => levels.of_faces(faces),
                Goal::Error(metres) => levels.of_error(metres / scale.z),
            };
            let path = self.path(goal, goals.len() > 1);
            rows.push(self.write_level(&level, &ground, (&path, format))?);
        }
        if self.json {
            println!("{}", self.summary(described, filled, seconds, rows));
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

    /// Bytes that simplifying takes a sample at its peak, heights and file included (measured: `/usr/bin/time -v`).
    fn bytes_a_sample(self) -> usize {
        match self {
            CostOption::Certified => 190,
            CostOption::Quadric | CostOption::Spring => 750,
        }
    }
}

/// All levels of a field; says so on stderr, since it can take minutes.
fn simplified(field: &Heightfield, holes: Option<Holes>, cost: Cost) -> anyhow::Result<Levels<'_>> {
    let collapses = (field.heights().len() - 4) as u64;
    eprintln!("terrane: simplifying {} x {} samples by {} cost", field.columns(), field.rows(), cost.name());
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(collapses) } else { ProgressBar::hidden() };
    bar.set_style(ProgressStyle::with_template("{bar:40} {percent}% {eta}")?);
    let mut progress = |done| bar.set_position(done as u64);
    let levels = match holes {
        Some(holes) => Levels::around(field, holes, &mut progress)?,
        None => Levels::new(field, cost, &mut progress)?,
    };
    bar.finish_and_clear();
    Ok(levels)
}

impl Simplify {
    /// Whether the mesh goes to stdout.
    fn to_stdout(&self) -> bool {
        self.out == Path::new("-")
    }

    fn mesh_format(&self) -> anyhow::Result<Format> {
        let Some(name) = &self.format else {
            ensure!(!self.to_stdout(), "--out -: found no --format, expected the format of stdout: {EXTENSIONS}");
            return Ok(Format::of(&self.out)?);
        };
        ensure!(
            self.to_stdout(),
            "--format: found --out {}, expected --out -: files have the format of their name",
            self.out.display()
        );
        ensure!(self.faces.len() + self.error.len() == 1, "--out -: found several levels, expected one, or the name of a file");
        ensure!(!self.json, "--out -: found --json, expected one or the other: both would go to stdout");
        ensure!(!self.export.sidecar, "--out -: found --sidecar, expected the name of a file for it to lie beside");
        Ok(Format::of(&Path::new("stdout").with_extension(name.trim_start_matches('.')))?)
    }

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

    /// A surface with all that its file holds.
    fn model<'a>(&self, surface: &'a TriangleSurface, ground: &Ground) -> anyhow::Result<Model<'a>> {
        let mut model = Model::of_heightfield(surface, ground.field, ground.scale);
        if let Some(origin) = &ground.origin {
            model = model.with_origin(origin.clone());
        }
        if let Some(below) = self.export.solid {
            model = model.solid(below);
        }
        if let Some(picture) = &ground.picture {
            model = model.with_picture(surface, [ground.field.columns(), ground.field.rows()], picture.clone());
        }
        if let Some(side) = self.export.maps {
            model = model.with_normal_map(surface, ground.field, ground.scale, side)?;
        }
        Ok(model)
    }

    fn write_level(&self, level: &Level, ground: &Ground, (path, format): (&Path, Format)) -> anyhow::Result<Value> {
        let begun = Instant::now();
        let Level { surface, deviation } = level;
        let model = self.model(surface, ground)?;
        let (volume, written) = (self.export.solid.map(|_| model.volume()), model.triangle_count());
        let sidecar = self.export.sidecar(&model, format)?;
        let bytes = self.export.encode(model, format)?;
        if self.to_stdout() {
            std::io::stdout().lock().write_all(&bytes).context("cannot write the mesh to stdout")?;
        } else {
            pictures::write_whole(path, &bytes).with_context(|| format!("cannot write the mesh {}", path.display()))?;
            sidecar.map_or(Ok(()), |sidecar| write_sidecar(path, &sidecar))?;
        }
        let (faces, vertices) = (surface.faces.len(), surface.positions.len());
        let (max, rms) = (deviation.max * ground.scale.z, deviation.rms * ground.scale.z);
        let seconds = begun.elapsed().as_secs_f64();
        if !self.json {
            let megabytes = bytes.len() as f64 / 1e6;
            let said = format!(
                "{}: {faces} triangles, {vertices} vertices, error up to {max:.3} m, {rms:.3} m rms, {megabytes:.1} MB",
                path.display()
            );
            if self.to_stdout() {
                eprintln!("{said}");
            } else {
                println!("{said}");
            }
        }
        Ok(json!({
            "faces": faces, "vertices": vertices, "max_error": max, "rms_error": rms, "uncovered": deviation.uncovered,
            "seconds": seconds, "file": path, "bytes": bytes.len(),
            "up": self.export.up_name(format)?, "volume_m3": volume, "triangles_in_file": written,
        }))
    }

    fn summary(&self, mut described: Value, filled: usize, seconds: f64, levels: Vec<Value>) -> Value {
        // Surfaces with holes keep their samples.
        let whole = self.input.gaps == Gaps::Fill || described["gaps"] == 0;
        let polished = !self.keep_samples && self.cost.cost() == Cost::Certified && whole;
        let own = json!({
            "heightfield": self.input.files[0], "heightfields": self.input.files, "filled": filled, "cost": self.cost.cost().name(),
            "polished": polished, "simplify_seconds": seconds, "levels": levels,
        });
        if let (Value::Object(all), Value::Object(own)) = (&mut described, own) {
            all.extend(own);
        }
        described
    }
}
