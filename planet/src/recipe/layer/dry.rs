//! Parameters of ground that the sea does not reach, with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::ReadLayer;
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// An area that stays dry although its ground lies below the sea: a basin without an outlet, a polder.
#[derive(Clone, Debug)]
pub struct Dry {
    /// Latitude of the middle, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of the middle, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Distance from the middle within which no sea is, in metres (1 to the planet's radius).
    pub radius_m: f64,
}

impl ReadLayer for Dry {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            radius_m: reader.number("radius_m", 1.0..=radius)?,
        })
    }
}
