//! Parameters of the noise layers with units and ranges: continents, mountains, hills, plains. In: one `[[layer]]` table. Out: the checked
//! layer.

use super::{read_above, Octaves, ReadLayer, Regions, METRES, WAVELENGTH};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;
use std::ops::RangeInclusive;

/// Oceans and continents: low noise through a profile of elevations.
#[derive(Clone, Debug)]
pub struct Continents {
    /// Octaves of the continent noise.
    pub octaves: Octaves,
    /// How far the noise domain is pushed about, in metres (0 to 1e7).
    pub warp_m: f64,
    /// Elevation profile: `[noise value, metres]`, both rising. Smooth and monotone in between, level beyond.
    pub profile: Vec<[f64; 2]>,
    /// Height of mid-ocean ridges above the floor, in metres (0 to 100000; default 0). They fade out between -3800 and -2500 m.
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
    /// Local relief of heightmaps over which the mountains grow, in metres; in place of ranges.
    pub relief_m: Option<[f64; 2]>,
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
    /// Where there are hills.
    pub regions: Regions,
    /// Local relief of heightmaps over which the hills grow, in metres.
    pub relief_m: Option<[f64; 2]>,
}

/// Gentle relief everywhere.
#[derive(Clone, Debug)]
pub struct Plains {
    /// Octaves of the relief.
    pub octaves: Octaves,
    /// Amplitude of the first octave, in metres.
    pub amplitude_m: f64,
}

impl ReadLayer for Continents {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e7, 0.0)?,
            profile: reader.rising_pairs("profile")?,
            ridge_m: reader.number_or("ridge_m", METRES, 0.0)?,
            north: reader.number_or("north", -2.0..=2.0, 0.0)?,
        })
    }
}

/// Everywhere, where the key is missing.
fn read_relief(reader: &Reader<'_>) -> Result<Option<[f64; 2]>, RecipeError> {
    reader.has("relief_m").then(|| reader.span("relief_m", METRES)).transpose()
}

impl ReadLayer for Mountains {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        let relief_m = read_relief(reader)?;
        // Mountains that follow the relief are in no ranges of their own.
        let of_range = |key: &'static str, range: RangeInclusive<f64>| match relief_m {
            Some(_) => Ok(1.0),
            None => reader.number(key, range),
        };
        Ok(Self {
            octaves: Octaves::read(reader)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e6, 0.0)?,
            range_m: of_range("range_m", WAVELENGTH)?,
            range_width: of_range("range_width", 0.01..=2.0)?,
            above_m: read_above(reader)?,
            relief_m,
        })
    }
}

impl ReadLayer for Hills {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            roundness: reader.number_or("roundness", -1.0..=1.0, 0.0)?,
            regions: Regions::read(reader)?,
            relief_m: read_relief(reader)?,
        })
    }
}

impl ReadLayer for Plains {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self { octaves: Octaves::read(reader)?, amplitude_m: reader.number("amplitude_m", METRES)? })
    }
}
