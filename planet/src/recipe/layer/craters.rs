//! Parameters of craters with units and ranges. In: one `[[layer]]` table. Out: the checked layer.

use super::{read_above, ReadLayer, UNIT};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// Craters in size classes, each half as large as the one before.
#[derive(Clone, Debug)]
pub struct Craters {
    /// Rim diameter of the largest craters, in metres.
    pub largest_m: f64,
    /// Rim diameter of the smallest class, in metres (at least 1).
    pub smallest_m: f64,
    /// Craters a cell of the largest class, which is as wide as two such craters' reach (0 to 4; default 1).
    pub density: f64,
    /// Factor on `density` for each smaller class (0.5 to 2): N(>D) ~ D^-(2 + log2 of this).
    pub growth: f64,
    /// Depth of small fresh craters relative to their diameter (0 to 0.4; default 0.2).
    pub depth: f64,
    /// Diameter in metres past which craters are complex: shallower, flat-floored, with a central peak.
    pub complex_m: f64,
    /// Reach of the ejecta or rays, in crater radii (1.5 to 12; default 2).
    pub reach: f64,
    /// Brightness of rays in the albedo (0 to 1; default 0).
    pub rays: f64,
    /// How far rims, walls and ejecta are from round and smooth (0 to 0.9; default 0).
    pub ragged: f64,
    /// Height of the rolling ground between craters, relative to the diameter of each class (0 to 0.1; default 0).
    pub rough: f64,
    /// How far craters are bent out of round, in metres (0 to a quarter of `largest_m`; default 0).
    pub warp_m: f64,
    /// Whether the craters are part of the base elevation, as basins are (default false).
    pub basins: bool,
    /// Base elevations over which craters fade in, in metres.
    pub above_m: [f64; 2],
    /// Share of the craters that show below `above_m`, the youngest (0 to 1; default 0).
    pub below: f64,
}

impl ReadLayer for Craters {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let reach = reader.number_or("reach", 1.5..=12.0, 2.0)?;
        // A crater's cell must stay small against the planet: its ejecta reach a third of the radius at most.
        let largest_m = reader.number("largest_m", 1.0..=0.7 * radius / reach)?;
        Ok(Self {
            largest_m,
            smallest_m: reader.number("smallest_m", 1.0..=largest_m)?,
            density: reader.number_or("density", 0.0..=4.0, 1.0)?,
            growth: reader.number_or("growth", 0.5..=2.0, 1.0)?,
            depth: reader.number_or("depth", 0.0..=0.4, 0.2)?,
            complex_m: reader.number_or("complex_m", 1.0..=1e8, 1e8)?,
            reach,
            rays: reader.number_or("rays", UNIT, 0.0)?,
            ragged: reader.number_or("ragged", 0.0..=0.9, 0.0)?,
            rough: reader.number_or("rough", 0.0..=0.1, 0.0)?,
            warp_m: reader.number_or("warp_m", 0.0..=0.25 * largest_m, 0.0)?,
            basins: reader.flag("basins")?,
            above_m: read_above(reader)?,
            below: reader.number_or("below", UNIT, 0.0)?,
        })
    }
}
