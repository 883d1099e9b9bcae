//! An area that the sea does not reach. In: unit directions. Out: how firmly the sea is kept out, from 0 to 1.

use super::layer::{Evaluate, Past};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};
use terrane_heightfield::angles::sin_cos;

/// Width of the border, in radii of the area.
const BORDER: f64 = 0.02;

/// A round area.
pub(crate) struct Dry {
    /// Its middle, in metres from the planet's centre.
    middle: [f64; 3],
    radius_m: f64,
}

impl Evaluate for Dry {
    type Recipe = recipe::Dry;

    fn new(_: u64, dry: &recipe::Dry, planet: &Recipe) -> Result<Self, RecipeError> {
        let ((north, across), (east, ahead)) = (sin_cos(dry.latitude_deg), sin_cos(dry.longitude_deg));
        let middle = [across * ahead, across * east, north].map(|c| c * planet.radius);
        Ok(Self { middle, radius_m: dry.radius_m })
    }

    /// It has none.
    #[inline(always)]
    fn metres(&self, _: &Points, _: &mut Past) -> Option<Lane> {
        None
    }

    #[inline(always)]
    fn dry(&self, p: &Points) -> Option<Lane> {
        let mut dry = [0.0; LANES];
        for i in 0..LANES {
            let off = [0, 1, 2].map(|k| p.position[k][i] - self.middle[k]);
            let distance = (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt();
            dry[i] = (0.5 + (self.radius_m - distance) / (BORDER * self.radius_m)).clamp(0.0, 1.0) as f32;
        }
        Some(dry)
    }

    fn lowest_dry(&self) -> Option<f64> {
        Some(f64::NEG_INFINITY)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (0.0, 0.0)
    }
}
