//! Where a layer shows: parts of the planet that a low noise picks out, above some base elevation. In: a chunk of points and the
//! base elevation. Out: a share for each point, 0 to 1.

use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use crate::recipe;

/// The regions of one layer.
pub(crate) struct Regions {
    noise: Fractal,
    /// Noise over which the layer fades in.
    cover: Ramp,
    /// Base elevations over which it does, in metres.
    above: Ramp,
}

impl Regions {
    /// Regions by a recipe: a cover of 1 is all of the planet.
    pub(crate) fn new(seed: u64, recipe: &recipe::Regions) -> Self {
        let cover = recipe.cover;
        let middle = 0.7 - 1.4 * cover;
        let edges = if cover >= 1.0 { [-9.0, -8.0] } else { [middle - 0.2, middle + 0.2] };
        Self { noise: Fractal::few(seed, recipe.region_m, 3), cover: Ramp::new(edges), above: Ramp::new(recipe.above_m) }
    }

    /// How much of the layer shows where; nothing where that is 0 throughout.
    #[inline(always)]
    pub(crate) fn mask(&self, p: &Points, base: &Lane) -> Option<Lane> {
        let mut mask = self.above.lanes(base);
        if !any_above_zero(&mask) {
            return None;
        }
        let noise = self.noise.brownian(p);
        for i in 0..LANES {
            mask[i] *= self.cover.at(noise[i]);
        }
        any_above_zero(&mask).then_some(mask)
    }
}
