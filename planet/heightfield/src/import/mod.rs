//! Reads heightfields from files: Terragen RAW, PNG, TIFF and GeoTIFF, SRTM HGT, Esri ASCII grids, and compressed ones.
//!
//! In: a file's bytes and its name, which says what the bytes of some formats do not, and what its owner adds. Out: the samples
//! in metres or levels, north row first; where they lie, or why that is not understood; and what was assumed. Or what was found
//! where, what was expected, and what to do next.

mod archive;
mod asc;
mod crs;
mod error;
mod gaps;
#[cfg(feature = "gdal")]
mod gdal;
mod geography;
mod geokeys;
mod geotiff;
mod hgt;
mod join;
mod metadata;
mod options;
pub mod photo;
mod place;
mod png;
mod raw;
mod tiff;
mod tiff_samples;
mod wkt;
mod world;

pub use error::{Fault, ImportError};
pub use geography::{Ellipsoid, GeographicGrid};
pub use join::join;
pub use options::{Encoding, NoData, Options, RawNumber, RawType, Window};
pub use place::Georeference;

use crate::Heightfield;
use error::Source;
use std::io::Read;
use std::path::Path;

/// Most samples of a heightfield: 512 MiB of heights, enough for a planet in 16,384 × 8,192. Larger files are refused
/// before any memory is taken for them.
pub const MOST_SAMPLES: usize = 1 << 27;

/// Most samples that a byte of a file can stand for. Deflate and LZW pack at most some 2,600 bytes into one, and tiles that are
/// left out take a few bytes each; files that claim more hold no such image, and are refused before memory is taken for it.
const MOST_SAMPLES_PER_BYTE: usize = 4096;

/// Most bytes of a file that is read as a whole: a line of digits a sample.
const MOST_BYTES: u64 = 24 * MOST_SAMPLES as u64;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Samples without a header: Terragen's export, `.r16`, `.r32`.
    Raw,
    /// PNG of 8 or 16 bits, or of colours that stand for heights.
    Png,
    /// TIFF of one band, with or without GeoTIFF tags.
    Tiff,
    /// A tile of the Shuttle Radar Topography Mission: a degree square, 16-bit, big-endian.
    Hgt,
    /// An Esri ASCII grid.
    Asc,
    /// Whatever the system's GDAL opens.
    #[cfg(feature = "gdal")]
    Gdal,
}

impl Format {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Format::Raw => "RAW",
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Hgt => "HGT",
            Format::Asc => "ASCII grid",
            #[cfg(feature = "gdal")]
            Format::Gdal => "GDAL raster",
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
    /// What the file declares as no data.
    pub declared_no_data: Option<f64>,
    /// The coordinate system and the place in it, if the file says and it is understood.
    pub georeference: Option<Georeference>,
    /// Where the samples lie, if that system is one of degrees.
    pub grid: Option<GeographicGrid>,
    /// Metres between samples from west to east and from north to south, if the file says so; on the body, in the middle.
    pub spacing_m: Option<[f64; 2]>,
    /// Why what the file says about its place is not understood. Only its owner can then say how far samples lie apart.
    pub unplaced: Option<Box<ImportError>>,
    /// What was assumed, and what looks wrong.
    pub notes: Vec<String>,
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
        let field = Heightfield::new(columns, rows, heights);
        let field = field.ok_or_else(|| source.refuse(Fault::Damaged, "samples missing", "columns times rows"))?;
        let (range, no_data, declared_no_data) = ([0.0; 2], 0, None);
        let (georeference, grid, spacing_m, unplaced, notes) = (None, None, None, None, Vec::new());
        let mut image =
            Imported { format, values, field, range, no_data, declared_no_data, georeference, grid, spacing_m, unplaced, notes };
        image.count();
        if image.no_data == columns * rows {
            return Err(source.refuse(Fault::Empty, "no sample with data", "at least one"));
        }
        Ok(image)
    }

    /// Turns levels into metres: `low + step * level`.
    pub fn to_metres(&mut self, low: f64, step: f64) {
        for height in &mut self.field.heights {
            *height = (low + step * f64::from(*height)) as f32;
        }
        self.values = Values::Metres;
        self.count();
    }

    /// Range and gaps, from the samples.
    fn count(&mut self) {
        let data = self.field.heights().iter().filter(|h| !h.is_nan());
        let (low, high) = data.clone().fold((f32::MAX, f32::MIN), |(low, high), &h| (low.min(h), high.max(h)));
        (self.range, self.no_data) = ([low, high], self.field.heights().len() - data.count());
    }
}

/// Reads a heightfield from the bytes of a file. The format follows from the first bytes or from the name's extension (`raw`,
/// `r16`, `r32`, `hgt`); an HGT tile's grid follows from its name, such as `N36W085.hgt`.
///
/// # Errors
/// For bytes that are none of these formats, damaged, of a kind of image that holds no heights, smaller than 2 × 2 or
/// larger than [`MOST_SAMPLES`], and for samples that are infinite. A place that is not understood is no error: see
/// [`Imported::unplaced`].
pub fn read(bytes: &[u8], name: &str) -> Result<Imported, ImportError> {
    read_with(bytes, name, &Options::default())
}

/// As [`read`], with what the file's owner adds.
///
/// # Errors
/// As [`read`], and for options that do not fit the file.
pub fn read_with(bytes: &[u8], name: &str, options: &Options) -> Result<Imported, ImportError> {
    decode(&Source::of_bytes(name, bytes, options), None)
}

/// Reads a heightfield from a file, as [`read`].
///
/// # Errors
/// If the file cannot be read, and as [`read`].
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    load_with(path, &Options::default())
}

/// Reads a heightfield from a file, as [`read_with`]. Of a TIFF only the part that is wanted is read.
///
/// # Errors
/// If the file cannot be read, and as [`read_with`].
pub fn load_with(path: &Path, options: &Options) -> Result<Imported, ImportError> {
    let name = path.display().to_string();
    let mut source = Source::of_bytes(&name, &[], options);
    let unreadable =
        |e: std::io::Error| Source::of_bytes(&name, &[], options).refuse(Fault::Unreadable, e.to_string(), "a readable file");
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    source.length = file.metadata().map_err(unreadable)?.len();
    let mut start = Vec::new();
    file.by_ref().take(8).read_to_end(&mut start).map_err(unreadable)?;
    let projection = std::fs::read_to_string(path.with_extension("prj")).ok();
    if is_tiff(&start) {
        source.path = Some(path);
        let image = world::placed(&source, or_gdal(&source, tiff::read(&source), path)?, path, projection.as_deref());
        return finished(&source, image);
    }
    if source.length > MOST_BYTES {
        let found = format!("{} bytes", source.length);
        return Err(source.refuse(Fault::Size, found, format!("at most {MOST_BYTES}")));
    }
    let mut bytes = start;
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    let source = Source { bytes: &bytes, ..source };
    let image = or_gdal(&source, decode(&source, projection.as_deref()), path)?;
    Ok(if image.format == Format::Png { world::placed(&source, image, path, projection.as_deref()) } else { image })
}

/// What GDAL reads of a file that is of a format or a coding that is not known here.
#[cfg(feature = "gdal")]
fn or_gdal(source: &Source, read: Result<Imported, ImportError>, path: &Path) -> Result<Imported, ImportError> {
    match read {
        Err(error) if matches!(error.fault, Fault::Format | Fault::Kind) && source.options.encoding.is_none() => {
            gdal::read(source, path, error)
        }
        read => read,
    }
}

#[cfg(not(feature = "gdal"))]
fn or_gdal(_: &Source, read: Result<Imported, ImportError>, _: &Path) -> Result<Imported, ImportError> {
    read
}

fn is_tiff(bytes: &[u8]) -> bool {
    matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
}

/// Reads a file whose bytes are there; `projection` is the text of a `.prj` beside it.
fn decode(source: &Source, projection: Option<&str>) -> Result<Imported, ImportError> {
    if let Some(inside) = archive::open(source)? {
        let source = Source { name: &inside.name, bytes: &inside.bytes, length: inside.bytes.len() as u64, ..*source };
        return finished(&source, decode_plain(&source, projection)?);
    }
    finished(source, decode_plain(source, projection)?)
}

fn decode_plain(source: &Source, projection: Option<&str>) -> Result<Imported, ImportError> {
    let extension = Path::new(source.name).extension().map(|e| e.to_string_lossy().to_lowercase());
    let options = source.options;
    match (source.bytes, extension.as_deref()) {
        (_, Some("r32")) => raw::read(source, RawType::FLOATS),
        _ if options.raw_size.is_some() || options.raw_type.is_some() => raw::read(source, RawType::LEVELS),
        ([0x89, b'P', b'N', b'G', ..], _) => png::read(source),
        (bytes, _) if is_tiff(bytes) => tiff::read(source),
        (bytes, _) if asc::is_grid(bytes) => asc::read(source, projection),
        (_, Some("raw" | "r16")) => raw::read(source, RawType::LEVELS),
        (_, Some("hgt")) => hgt::read(source),
        (bytes, None) if hgt::is_tile(bytes.len()) => hgt::read(source),
        (_, Some(known @ ("png" | "tif" | "tiff" | "asc"))) => {
            let found = format!("first bytes {:02x?}", &source.bytes[..source.bytes.len().min(4)]);
            Err(source.refuse(Fault::Damaged, found, format!("those of a {known} file")))
        }
        _ => Err(source.refuse(
            Fault::Format,
            "no format that can be told",
            "a PNG, TIFF or Esri ASCII grid, or a name that ends in .raw, .r16, .r32 or .hgt",
        )),
    }
}

fn has_overviews(format: Format) -> bool {
    !matches!(format, Format::Raw | Format::Png | Format::Hgt | Format::Asc)
}

fn reads_windows(format: Format) -> bool {
    has_overviews(format) || format == Format::Raw
}

/// What is done with images of all formats.
fn finished(source: &Source, mut image: Imported) -> Result<Imported, ImportError> {
    let options = source.options;
    if options.window.is_some() && !reads_windows(image.format) {
        let error = source.refuse(Fault::Kind, format!("a window of a {}", image.format.name()), "a TIFF or RAW file");
        return Err(error.with_advice("leave --window away, or convert it to GeoTIFF"));
    }
    if options.overview.is_some_and(|overview| overview > 0) && !has_overviews(image.format) {
        let error = source.refuse(Fault::Kind, format!("an overview of a {}", image.format.name()), "a TIFF");
        return Err(error.with_advice("leave --overview away, or convert it to GeoTIFF"));
    }
    gaps::look_at(&mut image, options.no_data);
    if image.no_data == image.field.heights().len() {
        return Err(source.refuse(Fault::Empty, "no sample with data", "at least one"));
    }
    Ok(image)
}
