//! Parameters of plains of lava with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{ReadLayer, METRES, WAVELENGTH};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Lava that fills low ground up to one level. It counts as base elevation.
#[derive(Clone, Debug)]
pub struct Lava {
    /// Level of the lava, in metres of base elevation.
    pub level_m: f64,
    /// Height over which the ground bends into the plain, in metres (1 to 100000; default 100).
    pub shore_m: f64,
    /// Height of wrinkle ridges, in metres (default 0: none).
    pub ridge_m: f64,
    /// Typical distance between them, in metres (default 100000).
    pub ridge_apart_m: f64,
}

impl ReadLayer for Lava {
    fn read(reader: &Reader<'_>, _: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            level_m: reader.number("level_m", -1e5..=1e5)?,
            shore_m: reader.number_or("shore_m", 1.0..=1e5, 100.0)?,
            ridge_m: reader.number_or("ridge_m", METRES, 0.0)?,
            ridge_apart_m: reader.number_or("ridge_apart_m", WAVELENGTH, 1e5)?,
        })
    }
}
