//! Parameters of dunes with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{read_above, ReadLayer, METRES, UNIT, WAVELENGTH};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Dunes or ripples across one wind, in part of the planet.
#[derive(Clone, Debug)]
pub struct Dunes {
    /// Distance from crest to crest, in metres (0.25 to 1e8).
    pub wavelength_m: f64,
    /// Height of the highest crests, in metres.
    pub amplitude_m: f64,
    /// Typical size of a dune field, in metres.
    pub region_m: f64,
    /// Share of the planet under dunes, about (0 to 1; default 0.5).
    pub cover: f64,
    /// Where dunes fade in, in metres of base elevation.
    pub above_m: [f64; 2],
}

impl ReadLayer for Dunes {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            wavelength_m: reader.number("wavelength_m", WAVELENGTH)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            region_m: reader.number("region_m", WAVELENGTH)?,
            cover: reader.number_or("cover", UNIT, 0.5)?,
            above_m: read_above(reader)?,
        })
    }
}
