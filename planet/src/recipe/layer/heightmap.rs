//! Parameters of heightfield files with units and ranges: where one lies, and how its samples become metres. In: one `[[layer]]` table.
//! Out: the checked layer.

use super::ReadLayer;
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;
use terrane_heightfield::import::{Encoding, NoData, Options, RawType};

/// Where a heightmap lies.
#[derive(Clone, Debug)]
pub enum Placement {
    /// The whole planet, equirectangular: the first row is north, the left edge is longitude -180.
    Planet,
    /// A rectangle about a point (gnomonic), at most a radius wide.
    Local {
        /// Latitude of the centre, in degrees (-90 to 90).
        latitude_deg: f64,
        /// Longitude of the centre, in degrees (-180 to 180).
        longitude_deg: f64,
        /// Width of the map on the ground, in metres; by default what the file says. Its height follows from the samples,
        /// which are square unless the file says otherwise.
        width_m: Option<f64>,
        /// Direction of the map's upper edge, in degrees clockwise from north (-360 to 360; default 0).
        heading_deg: f64,
        /// Width of the edge over which the map blends with the ground, in metres; by default a tenth of its width.
        blend_m: Option<f64>,
    },
    /// Where the file says: along parallels and meridians for GeoTIFFs in degrees and HGT tiles, at its middle for projections.
    File {
        /// Width of the edge over which the map blends with the ground, in metres; by default a tenth of its smaller side.
        blend_m: Option<f64>,
    },
}

/// How samples become metres.
#[derive(Clone, Debug)]
pub enum HeightScale {
    /// Heights of the lowest and of the highest level that the format can hold, in metres.
    Range([f64; 2]),
    /// `offset_m + scale * sample`, for formats that hold metres.
    Metres {
        /// Factor on the file's metres (0.001 to 1000; default 1).
        scale: f64,
        /// Height of the file's 0, in metres (default 0).
        offset_m: f64,
    },
}

/// Heightfield files that replace the elevation where they lie.
#[derive(Clone, Debug)]
pub struct Heightmap {
    /// The files' names, relative to the recipe; several are tiles that touch.
    pub files: Vec<String>,
    /// What they do not say themselves.
    pub reading: Options,
    /// How its samples become metres.
    pub heights: HeightScale,
    /// Where it lies.
    pub placement: Placement,
    /// Whether samples may move by up to half a level, so that gentle ground shows no steps (default false).
    pub smooth_steps: bool,
    /// Line and path of the `file` key, for messages.
    pub(crate) origin: (usize, String),
}

impl ReadLayer for Heightmap {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let expected = "the name of a heightfield file, such as N36W085.hgt or dem.tif, or names of tiles that touch";
        let files = reader.strings("file", expected)?;
        let origin = (reader.line_of("file"), reader.path_of("file"));
        let reading = reading(reader)?;
        Ok(Self {
            files,
            reading,
            heights: HeightScale::read(reader)?,
            placement: Placement::read(reader, radius)?,
            smooth_steps: reader.flag("smooth_steps")?,
            origin,
        })
    }
}

/// What a recipe says about files that do not say it themselves.
fn reading(reader: &Reader<'_>) -> Result<Options, RecipeError> {
    let text = |key: &'static str, expected: &str| reader.has(key).then(|| reader.string(key, expected)).transpose();
    let encoding = "\"terrarium\" or \"mapbox\"";
    let named = |name: String| Encoding::named(&name).ok_or_else(|| reader.wrong_name("encoding", &name, encoding));
    let raw = |name: String| RawType::named(&name).ok_or_else(|| reader.wrong_name("raw_type", &name, RawType::NAMES));
    let sides = |sides: [f64; 2]| {
        let whole = sides.map(|side| (side.fract() == 0.0).then_some(side as usize));
        let [Some(columns), Some(rows)] = whole else {
            let expected = "columns and rows, two whole numbers";
            return Err(reader.wrong("raw_size", reader.line_of("raw_size"), format!("{sides:?}"), expected));
        };
        Ok([columns, rows])
    };
    Ok(Options {
        crs: text("crs", "a coordinate system: \"EPSG:2264\", a proj string or WKT")?,
        no_data: reader.has("no_data").then(|| reader.number("no_data", f64::MIN..=f64::MAX)).transpose()?.map(NoData::Value),
        encoding: text("encoding", encoding)?.map(named).transpose()?,
        raw_size: reader.has("raw_size").then(|| reader.numbers("raw_size", 2.0..=1e6)).transpose()?.map(sides).transpose()?,
        raw_type: text("raw_type", RawType::NAMES)?.map(raw).transpose()?,
        ..Options::default()
    })
}

impl HeightScale {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let metres = ["scale", "offset_m"].into_iter().find(|key| reader.has(key));
        match metres {
            Some(key) if reader.has("range_m") => Err(reader.wrong(
                key,
                reader.line_of(key),
                "this key beside `range_m`",
                "`range_m` alone, or `scale` and `offset_m`",
            )),
            None if reader.has("range_m") => Ok(Self::Range(reader.span("range_m", -1e5..=1e5)?)),
            _ => Ok(Self::Metres {
                scale: reader.number_or("scale", 1e-3..=1e3, 1.0)?,
                offset_m: reader.number_or("offset_m", -1e5..=1e5, 0.0)?,
            }),
        }
    }
}

impl Placement {
    pub(super) fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let blend_m = |most: f64| reader.has("blend_m").then(|| reader.number("blend_m", 0.0..=most)).transpose();
        if reader.has("placement") {
            let expected = "\"file\"; without this key a map covers the planet, or lies at `latitude_deg` and `longitude_deg`";
            return match reader.string("placement", expected)?.as_str() {
                "file" => Ok(Self::File { blend_m: blend_m(radius)? }),
                other => Err(reader.wrong_name("placement", other, expected)),
            };
        }
        if !["latitude_deg", "longitude_deg", "width_m"].into_iter().any(|key| reader.has(key)) {
            return Ok(Self::Planet);
        }
        let width_m = reader.has("width_m").then(|| reader.number("width_m", 1.0..=radius)).transpose()?;
        Ok(Self::Local {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            width_m,
            heading_deg: reader.number_or("heading_deg", -360.0..=360.0, 0.0)?,
            blend_m: blend_m(0.5 * width_m.unwrap_or(radius))?,
        })
    }
}
