//! Reads heightfields from files: Terragen RAW, greyscale PNG, TIFF and GeoTIFF, SRTM HGT.
//!
//! In: a file's bytes and its name, which says what the bytes of some formats do not. Out: the samples as the file holds
//! them, and what it says about itself; or what was found where, what was expected, and what to do next.

mod error;
mod geography;
mod geotiff;
mod hgt;
pub mod photo;
mod png;
mod raw;
mod tiff;

pub use error::{Fault, ImportError};
pub use geography::GeographicGrid;

use crate::Heightfield;
use error::Source;
use std::path::Path;

/// Most samples of a heightfield: 512 MiB of heights, enough for a planet in 16,384 × 8,192. Larger files are refused
/// before any memory is taken for them.
pub const MOST_SAMPLES: usize = 1 << 27;

/// Most samples that a byte of a file can stand for. Deflate and LZW pack at most some 2,600 bytes into one; files that
/// claim more hold no such image, and are refused before memory is taken for it.
const MOST_SAMPLES_PER_BYTE: usize = 4096;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Terragen's export: square, 16-bit, little-endian, without a header.
    Raw,
    /// Greyscale PNG of 8 or 16 bits.
    Png,
    /// Greyscale TIFF of 16-bit integers or 32-bit floats, with or without GeoTIFF tags.
    Tiff,
    /// A tile of the Shuttle Radar Topography Mission: a degree square, 16-bit, big-endian.
    Hgt,
}

impl Format {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Format::Raw => "RAW",
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Hgt => "HGT",
        }
    }
}

/// What samples mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// Metres.
    Metres,
    /// Steps from 0 to `full`, whose heights only the user knows.
    Levels {
        /// The highest level that the format can hold.
        full: f64,
    },
}

/// A heightfield as a file holds it, and what the file says about itself.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The file's format.
    pub format: Format,
    /// What samples mean.
    pub values: Values,
    /// The samples; NaN where there is no data.
    pub field: Heightfield,
    /// Lowest and highest sample.
    pub range: [f32; 2],
    /// Samples without data.
    pub no_data: usize,
    /// Where the samples lie, if the file says so in degrees on WGS 84.
    pub grid: Option<GeographicGrid>,
    /// Metres between samples from west to east and from north to south, if the file says so; at the middle latitude for
    /// a grid in degrees.
    pub spacing_m: Option<[f64; 2]>,
}

impl Imported {
    /// Counts what the samples of a file hold.
    fn new(
        source: &Source,
        format: Format,
        values: Values,
        [columns, rows]: [usize; 2],
        heights: Vec<f32>,
    ) -> Result<Self, ImportError> {
        let data = heights.iter().filter(|h| !h.is_nan());
        let (low, high) = data.clone().fold((f32::MAX, f32::MIN), |(low, high), &h| (low.min(h), high.max(h)));
        let no_data = heights.len() - data.count();
        if no_data == heights.len() {
            return Err(source.refuse(Fault::Empty, "no sample with data", "at least one"));
        }
        let field = Heightfield::new(columns, rows, heights);
        let field = field.ok_or_else(|| source.refuse(Fault::Damaged, "samples missing", "columns times rows"))?;
        Ok(Imported { format, values, field, range: [low, high], no_data, grid: None, spacing_m: None })
    }

    /// The same on a geographic grid.
    fn at(self, grid: Option<GeographicGrid>) -> Imported {
        let spacing_m = grid.map(|g| g.spacing_m(self.field.rows()));
        Imported { grid, spacing_m, ..self }
    }
}

/// Reads a heightfield from the bytes of a file. The format follows from the first bytes (PNG, TIFF) or from the name's
/// extension (`raw`, `hgt`); an HGT tile's grid follows from its name, such as `N36W085.hgt`.
///
/// # Errors
/// For bytes that are none of these formats, damaged, of a kind of image that holds no heights, smaller than 2 × 2 or
/// larger than [`MOST_SAMPLES`], and for samples that are not numbers without being declared as no data.
pub fn read(bytes: &[u8], name: &str) -> Result<Imported, ImportError> {
    let source = Source { name, bytes };
    let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase());
    match (bytes, extension.as_deref()) {
        ([0x89, b'P', b'N', b'G', ..], _) => png::read(&source),
        ([b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..], _) => tiff::read(&source),
        (_, Some("raw")) => raw::read(&source),
        (_, Some("hgt")) => hgt::read(&source),
        (_, Some(known @ ("png" | "tif" | "tiff"))) => {
            let found = format!("first bytes {:02x?}", &bytes[..bytes.len().min(4)]);
            Err(source.refuse(Fault::Damaged, found, format!("those of a {known} file")))
        }
        _ => Err(source.refuse(
            Fault::Format,
            "no format that can be told",
            "a PNG or TIFF file, or a name that ends in .raw or .hgt",
        )),
    }
}

/// Reads a heightfield from a file, as [`read`].
///
/// # Errors
/// If the file cannot be read, and as [`read`].
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    let name = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => read(&bytes, &name),
        Err(error) => Err(Source { name: &name, bytes: &[] }.refuse(Fault::Unreadable, error.to_string(), "a readable file")),
    }
}
