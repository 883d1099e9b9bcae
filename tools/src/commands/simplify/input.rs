//! What `terrane simplify` reads: files, what their owner says about them, and what is said about them in turn.

use anyhow::{bail, ensure, Context as _};
use glam::DVec3;
use serde_json::{json, Value};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use terrane_heightfield::import;
use terrane_heightfield::import::{Encoding, Imported, NoData, Options, RawType, Values, Window};
use terrane_planet::export::Origin;

/// Metres between samples of a file that does not say.
const DEFAULT_SPACING_M: f64 = 1.0;

/// Share of the free memory that a mesh may take.
const MEMORY_SHARE: f64 = 0.9;

/// What becomes of samples without data.
#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gaps {
    /// They get heights from their surroundings.
    Fill,
    /// They become holes, whose borders follow the samples around.
    Cut,
}

#[derive(clap::Args)]
pub(super) struct Input {
    /// Heightfield files: PNG, TIFF or GeoTIFF, SRTM .hgt, Esri ASCII grid .asc, .raw, .r16, .r32, also as .gz or .zip; - for
    /// stdin. Several are joined where they touch.
    #[arg(value_name = "FILE", required = true)]
    pub(super) files: Vec<PathBuf>,
    /// Metres between samples, whatever the file says [default: what the file says, else 1].
    #[arg(long, value_name = "M")]
    spacing: Option<f64>,
    /// Metres a unit of height in the file [default: 1; files of levels need --range or this].
    #[arg(long, value_name = "M", conflicts_with = "range")]
    height_scale: Option<f64>,
    /// Heights in metres of the lowest and of the highest level that the file's numbers can hold.
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, value_parser = range)]
    range: Option<[f64; 2]>,
    /// Coordinate system of files that state none, or a wrong one: EPSG:2264, a proj string, or WKT.
    #[arg(long, value_name = "EPSG:N|PROJ")]
    crs: Option<String>,
    /// Number that stands for no data beside what the file declares; `declared`: nothing else does, whatever it looks like.
    #[arg(long, value_name = "V|declared", allow_negative_numbers = true, value_parser = no_data)]
    no_data: Option<NoData>,
    /// How colours stand for heights: terrarium or mapbox.
    #[arg(long, value_name = "terrarium|mapbox", value_parser = |name: &str| Encoding::named(name).ok_or("expected terrarium or mapbox"))]
    encoding: Option<Encoding>,
    /// Columns and rows of a file without a header.
    #[arg(long, value_name = "WxH", value_parser = size)]
    raw_size: Option<[usize; 2]>,
    #[arg(long, value_name = "TYPE", help = format!("Samples of a file without a header: {}", RawType::NAMES), value_parser = raw_type)]
    raw_type: Option<RawType>,
    /// Part of a TIFF or RAW file, in its samples.
    #[arg(long, value_name = "COLUMN,ROW,COLUMNS,ROWS", value_parser = window)]
    window: Option<Window>,
    /// A coarser image of a TIFF that has some; 1 is the finest.
    #[arg(long, value_name = "N")]
    overview: Option<usize>,
    /// What becomes of samples without data.
    #[arg(long, value_enum, default_value = "fill")]
    pub(super) gaps: Gaps,
}

/// What was read: heights in the unit that `scale` is about.
pub(super) struct Read {
    pub(super) image: Imported,
    /// Metres a sample spacing east and north, and a unit of height.
    pub(super) scale: DVec3,
    /// Where lengths come from, in words.
    spacing_from: &'static str,
}

fn no_data(text: &str) -> Result<NoData, String> {
    match text {
        "declared" => Ok(NoData::Declared),
        number => number.parse().map(NoData::Value).map_err(|_| "expected a number, or `declared`".into()),
    }
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let ends = text.split_once(',').and_then(|(low, high)| Some([low.trim().parse().ok()?, high.trim().parse().ok()?]));
    ends.ok_or_else(|| "expected two heights in metres, such as -100,2500".into())
}

fn raw_type(name: &str) -> Result<RawType, String> {
    RawType::named(name).ok_or_else(|| format!("expected {}", RawType::NAMES))
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.ok_or_else(|| "expected columns and rows, such as 1025x513".into())
}

fn window(text: &str) -> Result<Window, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[column, row, columns, rows]) => Ok(Window { column, row, columns, rows }),
        _ => Err("expected first column, first row, columns and rows, such as 0,0,1000,1000".into()),
    }
}

impl Input {
    /// Reads and joins the files. `bytes_a_sample` is what simplifying takes.
    pub(super) fn read(&self, bytes_a_sample: usize) -> anyhow::Result<Read> {
        self.check()?;
        let options = self.options(bytes_a_sample);
        let mut files = Vec::new();
        for path in &self.files {
            let image = load(path, &options)?;
            files.push((path.display().to_string(), image));
        }
        let name = files[0].0.clone();
        let several = files.len() > 1;
        if let (1, Some(unplaced), None) = (files.len(), &files[0].1.unplaced, self.spacing) {
            bail!("{unplaced}");
        }
        let mut image = import::join(files)?;
        let samples = image.field.heights().len();
        if let Some(most) = options.most_samples.filter(|&most| samples > most) {
            let needed = samples as f64 * bytes_a_sample as f64 / 1e9;
            bail!(
                "{samples} samples in all take {needed:.1} GB, and {:.1} GB are free; join fewer files",
                most as f64 * bytes_a_sample as f64 / 1e9
            );
        }
        let (spacing_m, spacing_from) = match (self.spacing, image.spacing_m) {
            (Some(metres), _) => ([metres; 2], "--spacing"),
            (None, Some(own)) => (own, "file"),
            (None, None) => {
                image.notes.push("states no spacing: 1 m between samples taken (--spacing M)".into());
                ([DEFAULT_SPACING_M; 2], "assumed")
            }
        };
        let height = self.heights(&mut image, &name)?;
        let read = Read { image, scale: DVec3::new(spacing_m[0], spacing_m[1], height), spacing_from };
        read.say(if several { "joined" } else { &name });
        Ok(read)
    }

    fn check(&self) -> anyhow::Result<()> {
        for (key, value) in [("--spacing", self.spacing), ("--height-scale", self.height_scale)] {
            let sound = value.is_none_or(|metres| (1e-6..=1e6).contains(&metres));
            ensure!(sound, "{key}: found {}, expected 0.000001 to 1000000 metres", value.unwrap_or_default());
        }
        if let Some([low, high]) = self.range {
            let sound = low < high && [low, high].iter().all(|h| h.abs() <= 1e6);
            ensure!(sound, "--range: found {low},{high}, expected two heights in metres, the lower first");
        }
        Ok(())
    }

    fn options(&self, bytes_a_sample: usize) -> Options {
        let free = free_memory().map(|bytes| (MEMORY_SHARE * bytes / bytes_a_sample as f64) as usize);
        Options {
            crs: self.crs.clone(),
            no_data: self.no_data,
            encoding: self.encoding,
            raw_size: self.raw_size,
            raw_type: self.raw_type,
            window: self.window,
            overview: self.overview,
            most_samples: free,
            bytes_a_sample: Some(bytes_a_sample),
        }
    }

    /// Metres a unit of height; levels become metres where their range is known.
    fn heights(&self, image: &mut Imported, name: &str) -> anyhow::Result<f64> {
        let format = image.format.name();
        match (image.values, self.range, self.height_scale) {
            (Values::Levels { full }, Some([low, high]), _) => {
                image.to_metres(low, (high - low) / full);
                Ok(1.0)
            }
            (Values::Levels { full }, _, None) => bail!(
                "{name}: found {format} of levels from 0 to {full}, expected heights; state those of its lowest and highest level \
                 (--range LOW,HIGH), or the metres a level (--height-scale M, 1 for levels that are metres)"
            ),
            (Values::Metres, Some(_), _) => bail!(
                "{name}: found --range for {format} in metres, expected levels; leave it away, or scale heights with --height-scale"
            ),
            (_, _, scale) => Ok(scale.unwrap_or(1.0)),
        }
    }
}

/// Reads a file, or stdin.
fn load(path: &Path, options: &Options) -> anyhow::Result<Imported> {
    if path != Path::new("-") {
        return Ok(import::load_with(path, options)?);
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes).context("cannot read stdin")?;
    Ok(import::read_with(&bytes, "-", options)?)
}

/// Memory that is free, in bytes, where the system says.
fn free_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| 1024.0 * kilobytes)
}

impl Read {
    /// Says on stderr what was assumed.
    fn say(&self, name: &str) {
        let [across, along] = [self.scale.x, self.scale.y];
        let spacing = format!("{across:.6} x {along:.6} m a sample ({})", self.spacing_from);
        match &self.image.georeference {
            Some(place) => eprintln!("terrane: {name}: {}, in units of 1 {}; {spacing}", place.crs, place.unit),
            None => eprintln!("terrane: {name}: {spacing}"),
        }
        for note in &self.image.notes {
            eprintln!("terrane: {name}: {note}");
        }
    }

    /// Where the south-western sample lies, if that is known.
    pub(super) fn origin(&self) -> Option<Origin> {
        let rows = self.image.field.rows();
        self.image.georeference.as_ref().map(|place| Origin::of_heightfield(place, rows, [self.scale.x, self.scale.y]))
    }

    /// The same for `--json`.
    pub(super) fn described(&self) -> Value {
        let Imported { field, grid, georeference, .. } = &self.image;
        let bounds = grid.map(|grid| {
            let (south, east) = (grid.south(field.rows()), grid.east(field.columns()));
            json!({ "west": grid.west, "south": south, "east": east, "north": grid.north })
        });
        let place = georeference.as_ref();
        json!({
            "format": self.image.format.name(), "columns": field.columns(), "rows": field.rows(), "range": self.image.range,
            "bounds_deg": bounds, "spacing_m": [self.scale.x, self.scale.y], "spacing_from": self.spacing_from,
            "height_scale_m": self.scale.z, "crs": place.map(|p| &p.crs), "origin": place.map(|p| p.origin),
            "step": place.map(|p| p.step), "unit": place.map(|p| &p.unit), "radius_m": place.map(|p| p.body.semi_major_m),
            "middle_deg": place.map(|p| p.middle_deg), "heading_deg": place.map(|p| p.heading_deg),
            "no_data": self.image.declared_no_data, "gaps": self.image.no_data, "notes": self.image.notes,
            "georeference": self.origin().as_ref().map(Origin::json),
        })
    }
}
