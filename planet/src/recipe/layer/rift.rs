//! Parameters of a rift valley with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{ReadLayer, METRES, UNIT};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// A rift valley.
#[derive(Clone, Debug)]
pub struct Rift {
    /// Latitude of its middle, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of its middle, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Which way it runs, in degrees clockwise from north (-360 to 360).
    pub heading_deg: f64,
    /// Length from end to end, in metres (1 to the planet's radius and a half).
    pub length_m: f64,
    /// Width from rim to rim, in metres (1 to half of `length_m`).
    pub width_m: f64,
    /// Depth of the floor, in metres.
    pub depth_m: f64,
    /// How much the walls are stairs, and not slopes (0 to 1; default 0.3).
    pub ledges: f64,
}

impl ReadLayer for Rift {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let length_m = reader.number("length_m", 1.0..=1.5 * radius)?;
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            heading_deg: reader.number("heading_deg", -360.0..=360.0)?,
            length_m,
            width_m: reader.number("width_m", 1.0..=0.5 * length_m)?,
            depth_m: reader.number("depth_m", METRES)?,
            ledges: reader.number_or("ledges", UNIT, 0.3)?,
        })
    }
}
