//! Parameters of coasts and of the sea floor beyond them, from a picture, with units and ranges. In: one `[[layer]]` table. Out: the
//! checked layer.

use super::{PictureFile, ReadLayer};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;
use std::ops::RangeInclusive;

/// Widths along the ground, in metres.
const WIDTH: RangeInclusive<f64> = 1.0..=1e7;
/// Depths below the sea, in metres.
const DEPTH: RangeInclusive<f64> = 0.0..=12_000.0;

/// Land where a picture of the whole planet shows land, and a sea floor where it shows water: shelf, slope and abyss by the distance from
/// the coast. It counts as base elevation.
#[derive(Clone, Debug)]
pub struct Seabed {
    /// The picture.
    pub file: PictureFile,
    /// Waters smaller than this are lakes: land (0 to 1e9 km²; default 300,000).
    pub smallest_km2: f64,
    /// Least height of the land, which it has from `shore_m` inland on, in metres (0 to 1000; default 3).
    pub land_m: f64,
    /// Width of the strip of land that comes down to the sea, in metres (default 15,000).
    pub shore_m: f64,
    /// How far coasts stray from where the picture has them, in metres (0 to 1e6; default 0).
    pub ragged_m: f64,
    /// Width of the shelf, in metres (default 90,000).
    pub shelf_m: f64,
    /// Depth of its edge, in metres (default 140).
    pub shelf_depth_m: f64,
    /// Width of the continental slope, in metres (default 160,000).
    pub slope_m: f64,
    /// Depth at its foot, in metres (default 3,400).
    pub slope_depth_m: f64,
    /// Depth far from all coasts, in metres (default 5,200).
    pub abyss_depth_m: f64,
}

impl ReadLayer for Seabed {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let shelf_depth_m = reader.number_or("shelf_depth_m", DEPTH, 140.0)?;
        let slope_depth_m = reader.number_or("slope_depth_m", shelf_depth_m..=*DEPTH.end(), 3400.0_f64.max(shelf_depth_m))?;
        Ok(Self {
            file: PictureFile::read(reader)?,
            smallest_km2: reader.number_or("smallest_km2", 0.0..=1e9, 300_000.0)?,
            land_m: reader.number_or("land_m", 0.0..=1000.0, 3.0)?,
            shore_m: reader.number_or("shore_m", WIDTH, 15e3)?,
            ragged_m: reader.number_or("ragged_m", 0.0..=1e6_f64.min(radius), 0.0)?,
            shelf_m: reader.number_or("shelf_m", WIDTH, 90e3)?,
            shelf_depth_m,
            slope_m: reader.number_or("slope_m", WIDTH, 160e3)?,
            slope_depth_m,
            abyss_depth_m: reader.number_or("abyss_depth_m", slope_depth_m..=*DEPTH.end(), 5200.0_f64.max(slope_depth_m))?,
        })
    }
}
