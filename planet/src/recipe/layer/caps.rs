//! Parameters of polar caps with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{ReadLayer, METRES};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Domes of ice about both poles, with spiral troughs.
#[derive(Clone, Debug)]
pub struct Caps {
    /// Latitude of their edge, in degrees (45 to 89).
    pub latitude_deg: f64,
    /// Height of the pole above the ground, in metres.
    pub height_m: f64,
    /// Depth of the deepest troughs, in metres.
    pub trough_m: f64,
    /// Distance from trough to trough, in metres (1000 to 1e6).
    pub apart_m: f64,
}

impl ReadLayer for Caps {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", 45.0..=89.0)?,
            height_m: reader.number("height_m", METRES)?,
            trough_m: reader.number_or("trough_m", METRES, 0.0)?,
            apart_m: reader.number_or("apart_m", 1e3..=1e6, 5e4)?,
        })
    }
}
