//! Parameters of a volcano with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{ReadLayer, METRES};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// A shield volcano, or with neither scarp nor caldera a swell. It counts as base elevation.
#[derive(Clone, Debug)]
pub struct Shield {
    /// Latitude of the top, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of the top, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Distance of the foot from the top, in metres (1 to the planet's radius).
    pub radius_m: f64,
    /// Height of the top, in metres.
    pub height_m: f64,
    /// Share of the height that is a scarp at the foot (0 to 0.5; default 0).
    pub scarp: f64,
    /// Radius of the caldera, in metres (0 to half of `radius_m`; default 0: none).
    pub caldera_m: f64,
    /// Depth of the caldera, in metres (default 0).
    pub caldera_depth_m: f64,
}

impl ReadLayer for Shield {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let radius_m = reader.number("radius_m", 1.0..=radius)?;
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            radius_m,
            height_m: reader.number("height_m", METRES)?,
            scarp: reader.number_or("scarp", 0.0..=0.5, 0.0)?,
            caldera_m: reader.number_or("caldera_m", 0.0..=0.5 * radius_m, 0.0)?,
            caldera_depth_m: reader.number_or("caldera_depth_m", METRES, 0.0)?,
        })
    }
}
