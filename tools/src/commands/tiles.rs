//! `terrane tiles`: a planet as 3D Tiles, for other renderers.

use super::building::{stop_on_signals, Report};
use super::height::open_planet;
use super::output::{check_output, Output};
use super::packing::{unpacked, Meshoptimizer};
use super::region::RegionOptions;
use super::Run;
use crate::Outcome;
use anyhow::bail;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use terrane_planet::export::glb::MeshCodec;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::bake::BakePlan;
use terrane_planet::store::PlanetFile;
use terrane_planet::tiles::{check, PictureCodec, Published, TileMaker, Watch, TILESET};

/// Quality of the maps.
const QUALITY: u8 = 88;

/// Write a planet as 3D Tiles 1.1, for CesiumJS, three.js, Unreal, Unity and others. Needs no GPU.
///
/// A tile is a patch: a GLB with its ground, maps of albedo and normals, its sea, and skirts. Patches are those of the planet file, or are
/// built. The folder can be handed out by any web server; tileset.json is the address to open. Files are named by their bytes, so that a planet
/// that has changed a little changes few files; those that are there are kept.
#[derive(clap::Args)]
pub(crate) struct Tiles {
    /// Planet file, or a recipe: a TOML file, or the name of one that comes with the command.
    #[arg(required_unless_present = "check")]
    file: Option<PathBuf>,
    /// Folder to write into.
    #[arg(long, short, value_name = "FOLDER", required_unless_present = "check")]
    out: Option<PathBuf>,
    /// Finest level of the whole planet; 0 is the six cube faces.
    #[arg(long, short, default_value_t = 3)]
    levels: u8,
    #[command(flatten)]
    region: RegionOptions,
    /// Texels a side of the maps of a tile: a power of two.
    #[arg(long, value_name = "TEXELS", default_value_t = 256)]
    maps: u32,
    /// Pack triangles and vertices (EXT_meshopt_compression): smaller files, for readers that know the extension.
    #[arg(long)]
    pack: bool,
    /// Leave out the walls that close gaps between tiles, to see what they are for.
    #[arg(long, hide = true)]
    no_skirts: bool,
    /// Only check the tiles in a folder: files, hashes, errors and boxes.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["file", "out", "levels", "region", "to_level", "maps", "pack"])]
    check: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Encodes maps, with colours as sharp as the rest: normals have no brightness.
struct Jpeg;

impl PictureCodec for Jpeg {
    fn jpeg(&self, [width, height]: [u32; 2], texels: &[[u8; 3]]) -> Result<Vec<u8>, String> {
        let side = |side: u32| u16::try_from(side).map_err(|_| format!("{side} texels a side"));
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, QUALITY);
        encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
        encoder.set_optimized_huffman_tables(true);
        encoder.encode(texels.as_flattened(), side(width)?, side(height)?, ColorType::Rgb).map_err(|error| error.to_string())?;
        Ok(bytes)
    }
}

impl Run for Tiles {
    fn run(self) -> anyhow::Result<Outcome> {
        if let Some(folder) = &self.check {
            let found = checked(folder)?;
            self.print(folder, None, &found, 0.0);
            return Ok(Outcome::Done);
        }
        let (Some(input), Some(out)) = (&self.file, &self.out) else { bail!("expected a planet and --out, or --check") };
        check_output("--out", out, Output::Folder)?;
        let begun = Instant::now();
        let (planet, file) = open_planet(input)?;
        let plan = BakePlan::new(planet.recipe.radius, self.levels, self.region.region())?;
        let file = file.map(Mutex::new);
        let source = |id: PatchId| {
            let Some(file) = &file else { return Ok(None) };
            let file: &PlanetFile = &file.lock().unwrap_or_else(PoisonError::into_inner);
            file.contains(id)?.then(|| file.mesh(id)).transpose()
        };
        let maker = TileMaker {
            planet: &planet,
            source: &source,
            map_side: self.maps,
            codec: self.pack.then_some(&Meshoptimizer as &(dyn MeshCodec + Sync)),
            pictures: &Jpeg,
            skirts: !self.no_skirts,
        };
        let stop = stop_on_signals()?;
        let name = &planet.recipe.name;
        let published = {
            let measured = Report::counting(&format!("{name}: measuring"), "patches");
            let step = |report: &Report, done, total| report.step(done, total, begun.elapsed());
            let certified = maker.certify(&plan.patches, &Watch { progress: &|d, t| step(&measured, d, t), stop: &stop })?;
            measured.finish();
            let written = Report::counting(&format!("{name}: writing"), "tiles");
            let watch = Watch { progress: &|d, t| step(&written, d, t), stop: &stop };
            let published = certified.map(|certified| maker.publish(&certified, out, &watch)).transpose()?.flatten();
            written.finish();
            published
        };
        let Some(published) = published else {
            eprintln!("terrane: interrupted; the same command goes on from what is in {}", out.display());
            return Ok(Outcome::Interrupted);
        };
        let seconds = begun.elapsed().as_secs_f64();
        let found = checked(out)?;
        self.print(out, Some(&published), &found, seconds);
        Ok(Outcome::Done)
    }
}

/// What a check of a folder found, if that is no fault.
fn checked(folder: &Path) -> anyhow::Result<check::Report> {
    let report = check::check(folder, &unpacked);
    if report.faults > 0 {
        let more = report.faults - report.described.len();
        let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
        bail!("{}: {} faults; make the tiles again\n  {}{more}", folder.display(), report.faults, report.described.join("\n  "));
    }
    Ok(report)
}

impl Tiles {
    fn print(&self, folder: &Path, published: Option<&Published>, found: &check::Report, seconds: f64) {
        if self.json {
            let mut summary = json!({
                "tileset": folder.join(TILESET), "tiles": found.tiles, "files": found.files, "bytes": found.bytes,
                "triangles": found.triangles, "strays": found.strays, "faults": found.faults,
            });
            if let (Some(made), Value::Object(summary)) = (published, &mut summary) {
                let more = json!({
                    "written": made.written, "kept": made.kept, "removed": made.removed, "tile_bytes": made.tile_bytes,
                    "finest_error_m": made.finest_error, "coarsest_error_m": made.coarsest_error, "seconds": seconds,
                });
                summary.extend(more.as_object().cloned().unwrap_or_default());
            }
            println!("{summary}");
            return;
        }
        let check::Report { tiles, files, triangles, .. } = *found;
        println!(
            "{}: {tiles} tiles, {triangles} triangles, {files} files, {:.1} MB",
            folder.join(TILESET).display(),
            found.bytes as f64 / 1e6
        );
        if let Some(made) = published {
            println!("{} files written, {} kept, {} removed, {seconds:.1} s", made.written, made.kept, made.removed);
            println!("radial error {:.3} m at the finest tiles, {:.0} m at the coarsest", made.finest_error, made.coarsest_error);
        }
        println!(
            "checked: files, hashes, errors and boxes{}",
            match found.strays {
                0 => String::new(),
                strays => format!("; {strays} files there belong to no tile"),
            }
        );
    }
}
