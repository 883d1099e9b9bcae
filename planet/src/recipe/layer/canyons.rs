//! Parameters of canyons with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{Octaves, ReadLayer, Regions, METRES, UNIT};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Valleys with walls, floors and side valleys, in part of the planet.
#[derive(Clone, Debug)]
pub struct Canyons {
    /// Octaves of the network: the first sets how far apart the main canyons are, the others their side valleys.
    pub octaves: Octaves,
    /// Depth of the floor below the ground around, in metres.
    pub depth_m: f64,
    /// How far the network is pushed about, in metres (0 to 1e6; default 0).
    pub warp_m: f64,
    /// Width from rim to rim (0.02 to 0.9): the share of the network's noise that lies within the rims.
    pub width: f64,
    /// Share of the width that is walls, and not floor (0.05 to 1; default 0.5).
    pub wall: f64,
    /// How much the walls are stairs, and not slopes (0 to 1; default 0.5).
    pub ledges: f64,
    /// Where there are canyons.
    pub regions: Regions,
}

impl ReadLayer for Canyons {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            depth_m: reader.number("depth_m", METRES)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e6, 0.0)?,
            width: reader.number("width", 0.02..=0.9)?,
            wall: reader.number_or("wall", 0.05..=1.0, 0.5)?,
            ledges: reader.number_or("ledges", UNIT, 0.5)?,
            regions: Regions::read(reader)?,
        })
    }
}
