//! The layers a terrain is composed of, in order, and their parameters with units and ranges. In: one `[[layer]]` table.
//! Out: a checked [`Layer`]. What each layer looks like is in `recipes/README.md`.

use super::error::RecipeError;
use super::landform::{Canyons, Caps, Dunes, Lava, Rift, Shield};
use super::reader::Reader;
use std::ops::RangeInclusive;

pub(super) const METRES: RangeInclusive<f64> = 0.0..=100_000.0;
/// Longest and shortest wavelength of a noise octave, in metres. 0.25 m on the largest radius keeps cells below 2^30.
pub(super) const WAVELENGTH: RangeInclusive<f64> = 0.25..=1e8;
pub(super) const UNIT: RangeInclusive<f64> = 0.0..=1.0;

/// A run of noise octaves, each half (nearly) as long as the one before.
#[derive(Clone, Debug)]
pub struct Octaves {
    /// Wavelength of the first octave, in metres (0.25 to 1e8).
    pub wavelength_m: f64,
    /// No octave is shorter than this, in metres (0.25 to 1e8; default 1).
    pub detail_m: f64,
    /// Amplitude of each octave relative to the one before (0.2 to 0.8). 0.5 is H = 1, 0.57 about H = 0.8.
    pub gain: f64,
}

/// Oceans and continents: low noise through a profile of elevations.
#[derive(Clone, Debug)]
pub struct Continents {
    /// Octaves of the continent noise.
    pub octaves: Octaves,
    /// How far the noise domain is pushed about, in metres (0 to 1e7).
    pub warp_m: f64,
    /// Elevation profile: `[noise value, metres]`, both rising. Smooth and monotone in between, level beyond.
    pub profile: Vec<[f64; 2]>,
    /// Height of mid-ocean ridges above the floor, in metres (0 to 100000; default 0). They fade out above -2000 m.
    pub ridge_m: f64,
    /// Noise added at the north pole, and taken at the south pole (-2 to 2; default 0): below 0 the north lies low.
    pub north: f64,
}

/// Mountain ranges: eroded massifs in a warped domain, along the zero lines of a range noise.
#[derive(Clone, Debug)]
pub struct Mountains {
    /// Width of massifs, and the octaves of their gullies and crags.
    pub octaves: Octaves,
    /// Height of the highest ridge, in metres.
    pub amplitude_m: f64,
    /// How far the domain is pushed about, in metres (0 to 1e6).
    pub warp_m: f64,
    /// Typical distance between ranges, in metres.
    pub range_m: f64,
    /// Width of ranges (0.01 to 2): the range noise at which they end.
    pub range_width: f64,
    /// Where ranges fade in, in metres of base elevation.
    pub above_m: [f64; 2],
}

/// Rolling hills, or (with `roundness`) mounds with gullies between them, in part of the planet.
#[derive(Clone, Debug)]
pub struct Hills {
    /// Octaves of the hills.
    pub octaves: Octaves,
    /// Amplitude of the first octave, in metres.
    pub amplitude_m: f64,
    /// 0: plain noise; 1: rounded mounds with gullies between them; -1: rounded pans with sharp crests between them.
    pub roundness: f64,
    /// Typical size of a hilly region, in metres.
    pub region_m: f64,
    /// Share of the planet that is hilly, about (0 to 1; default 0.5).
    pub cover: f64,
    /// Where hills fade in, in metres of base elevation.
    pub above_m: [f64; 2],
}

/// Gentle relief everywhere.
#[derive(Clone, Debug)]
pub struct Plains {
    /// Octaves of the relief.
    pub octaves: Octaves,
    /// Amplitude of the first octave, in metres.
    pub amplitude_m: f64,
}

/// Craters in size classes, each half as large as the one before.
#[derive(Clone, Debug)]
pub struct Craters {
    /// Rim diameter of the largest craters, in metres.
    pub largest_m: f64,
    /// Rim diameter of the smallest class, in metres (at least 1).
    pub smallest_m: f64,
    /// Craters a cell of the largest class, which is as wide as two such craters' reach (0 to 4; default 1).
    pub density: f64,
    /// Factor on `density` for each smaller class (0.5 to 2): N(>D) ~ D^-(2 + log2 of this).
    pub growth: f64,
    /// Depth of small fresh craters relative to their diameter (0 to 0.4; default 0.2).
    pub depth: f64,
    /// Diameter in metres past which craters are complex: shallower, flat-floored, with a central peak.
    pub complex_m: f64,
    /// Reach of the ejecta or rays, in crater radii (1.5 to 12; default 2).
    pub reach: f64,
    /// Brightness of rays in the albedo (0 to 1; default 0).
    pub rays: f64,
    /// How far rims, walls and ejecta are from round and smooth (0 to 0.9; default 0).
    pub ragged: f64,
    /// Height of the rolling ground between craters, relative to the diameter of each class (0 to 0.1; default 0).
    pub rough: f64,
    /// How far craters are bent out of round, in metres (0 to a quarter of `largest_m`; default 0).
    pub warp_m: f64,
    /// Whether the craters are part of the base elevation, as basins are (default false).
    pub basins: bool,
    /// Base elevations over which craters fade in, in metres.
    pub above_m: [f64; 2],
    /// Share of the craters that show below `above_m`, the youngest (0 to 1; default 0).
    pub below: f64,
}

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
    /// Where the file says, along parallels and meridians: GeoTIFFs in degrees and HGT tiles.
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

/// A heightfield file that replaces the elevation where it lies.
#[derive(Clone, Debug)]
pub struct Heightmap {
    /// The file's name, relative to the recipe.
    pub file: String,
    /// How its samples become metres.
    pub heights: HeightScale,
    /// Where it lies.
    pub placement: Placement,
    /// Line and path of the `file` key, for messages.
    pub(crate) origin: (usize, String),
}

/// One layer of the terrain.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Oceans and continents.
    Continents(Continents),
    /// Mountain ranges.
    Mountains(Mountains),
    /// Hills, mounds, gullies.
    Hills(Hills),
    /// Gentle relief.
    Plains(Plains),
    /// Impact craters.
    Craters(Craters),
    /// Valleys with walls.
    Canyons(Canyons),
    /// Dunes and ripples.
    Dunes(Dunes),
    /// Plains of lava.
    Lava(Lava),
    /// Polar caps.
    Caps(Caps),
    /// A volcano.
    Shield(Shield),
    /// A rift valley.
    Rift(Rift),
    /// A heightfield file.
    Heightmap(Heightmap),
}

impl Layer {
    pub(crate) fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let kinds = "a layer kind: continents, mountains, hills, plains, craters, canyons, dunes, lava, caps, shield, rift, \
                     heightmap";
        let kind = reader.string("kind", kinds)?;
        let layer = match kind.as_str() {
            "continents" => Self::Continents(Continents::read(reader)?),
            "mountains" => Self::Mountains(Mountains::read(reader)?),
            "hills" => Self::Hills(Hills::read(reader)?),
            "plains" => Self::Plains(Plains::read(reader)?),
            "craters" => Self::Craters(Craters::read(reader, radius)?),
            "canyons" => Self::Canyons(Canyons::read(reader)?),
            "dunes" => Self::Dunes(Dunes::read(reader)?),
            "lava" => Self::Lava(Lava::read(reader)?),
            "caps" => Self::Caps(Caps::read(reader)?),
            "shield" => Self::Shield(Shield::read(reader, radius)?),
            "rift" => Self::Rift(Rift::read(reader, radius)?),
            "heightmap" => Self::Heightmap(Heightmap::read(reader, radius)?),
            other => return Err(reader.wrong("kind", reader.line_of("kind"), format!("string \"{other}\""), kinds)),
        };
        reader.finish()?;
        Ok(layer)
    }
}

impl Octaves {
    pub(super) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let wavelength_m = reader.number("wavelength_m", WAVELENGTH)?;
        let detail_m = reader.number_or("detail_m", *WAVELENGTH.start()..=wavelength_m, wavelength_m.min(1.0))?;
        Ok(Self { wavelength_m, detail_m, gain: reader.number("gain", 0.2..=0.8)? })
    }
}

/// Everywhere, where the key is missing: no base elevation is this low.
pub(super) fn read_above(reader: &Reader<'_>) -> Result<[f64; 2], RecipeError> {
    if reader.has("above_m") {
        reader.span("above_m", -1e5..=1e5)
    } else {
        Ok([-3e5, -2e5])
    }
}

impl Continents {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e7, 0.0)?,
            profile: reader.rising_pairs("profile")?,
            ridge_m: reader.number_or("ridge_m", METRES, 0.0)?,
            north: reader.number_or("north", -2.0..=2.0, 0.0)?,
        })
    }
}

impl Mountains {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e6, 0.0)?,
            range_m: reader.number("range_m", WAVELENGTH)?,
            range_width: reader.number("range_width", 0.01..=2.0)?,
            above_m: read_above(reader)?,
        })
    }
}

impl Hills {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            roundness: reader.number_or("roundness", -1.0..=1.0, 0.0)?,
            region_m: reader.number("region_m", WAVELENGTH)?,
            cover: reader.number_or("cover", UNIT, 0.5)?,
            above_m: read_above(reader)?,
        })
    }
}

impl Plains {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self { octaves: Octaves::read(reader)?, amplitude_m: reader.number("amplitude_m", METRES)? })
    }
}

impl Craters {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let reach = reader.number_or("reach", 1.5..=12.0, 2.0)?;
        // A crater's cell must stay small against the planet: its ejecta reach a third of the radius at most.
        let largest_m = reader.number("largest_m", 1.0..=0.7 * radius / reach)?;
        Ok(Self {
            largest_m,
            smallest_m: reader.number("smallest_m", 1.0..=largest_m)?,
            density: reader.number_or("density", 0.0..=4.0, 1.0)?,
            growth: reader.number_or("growth", 0.5..=2.0, 1.0)?,
            depth: reader.number_or("depth", 0.0..=0.4, 0.2)?,
            complex_m: reader.number_or("complex_m", 1.0..=1e8, 1e8)?,
            reach,
            rays: reader.number_or("rays", UNIT, 0.0)?,
            ragged: reader.number_or("ragged", 0.0..=0.9, 0.0)?,
            rough: reader.number_or("rough", 0.0..=0.1, 0.0)?,
            warp_m: reader.number_or("warp_m", 0.0..=0.25 * largest_m, 0.0)?,
            basins: reader.flag("basins")?,
            above_m: read_above(reader)?,
            below: reader.number_or("below", UNIT, 0.0)?,
        })
    }
}

impl Heightmap {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let file = reader.string("file", "the name of a heightfield file: PNG, TIFF, .hgt or .raw")?;
        let origin = (reader.line_of("file"), reader.path_of("file"));
        Ok(Self { file, heights: HeightScale::read(reader)?, placement: Placement::read(reader, radius)?, origin })
    }
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
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let blend_m = |most: f64| reader.has("blend_m").then(|| reader.number("blend_m", 0.0..=most)).transpose();
        if reader.has("placement") {
            let expected = "\"file\"; without this key a map covers the planet, or lies at `latitude_deg` and `longitude_deg`";
            return match reader.string("placement", expected)?.as_str() {
                "file" => Ok(Self::File { blend_m: blend_m(radius)? }),
                other => Err(reader.wrong("placement", reader.line_of("placement"), format!("string \"{other}\""), expected)),
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
