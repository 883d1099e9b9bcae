//! Parameters of dunes with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{ReadLayer, Regions, METRES, WAVELENGTH};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Dunes or ripples across one wind, in part of the planet.
#[derive(Clone, Debug)]
pub struct Dunes {
    /// Distance from crest to crest, in metres (0.25 to 1e8).
    pub wavelength_m: f64,
    /// Height of the highest crests, in metres.
    pub amplitude_m: f64,
    /// Where there are dunes.
    pub regions: Regions,
}

impl ReadLayer for Dunes {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            wavelength_m: reader.number("wavelength_m", WAVELENGTH)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            regions: Regions::read(reader)?,
        })
    }
}
