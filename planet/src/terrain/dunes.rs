//! Transverse dunes: asymmetric ridges across the wind, bent and broken by noise. In: a chunk of points in metres and the base
//! elevation. Out: metres of the layer's own at each point, never below 0, or nothing where there are none in the whole chunk.

use super::layer::{Evaluate, Past};
use super::noise::{mix, nearest};
use super::octaves::{Fractal, Ramp};
use super::points::{Lane, Points, LANES, TURNS};
use super::regions::Regions;
use crate::recipe::{self, Recipe, RecipeError};

/// Share of a dune's width that faces the wind.
const WINDWARD: f32 = 0.76;

/// Dunes whose crests are closer than this are ripples, in metres.
const RIPPLES_M: f64 = 50.0;

/// One field of dunes.
pub(crate) struct Dunes {
    /// The orientation whose first axis is the wind.
    turn: usize,
    per_metre: f64,
    /// One over the planet's radius, in 1/m.
    per_radius: f64,
    /// Bends the ridges.
    bend: Fractal,
    /// Raises some and ends others.
    vigour: Fractal,
    regions: Regions,
    amplitude_m: f64,
}

impl Evaluate for Dunes {
    type Recipe = recipe::Dunes;

    fn new(seed: u64, recipe: &recipe::Dunes, planet: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            turn: (seed >> 32) as usize % TURNS,
            per_metre: 1.0 / recipe.wavelength_m,
            per_radius: 1.0 / planet.radius,
            bend: Fractal::few(mix(seed ^ 1), recipe.wavelength_m * 8.0, 3),
            vigour: Fractal::few(mix(seed ^ 3), recipe.wavelength_m * 3.0, 2),
            regions: Regions::new(mix(seed ^ 2), &recipe.regions),
            amplitude_m: recipe.amplitude_m,
        })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        let mut own = self.mask(p, &past.base)?;
        let (bend, vigour) = (self.bend.brownian(p), self.vigour.brownian(p));
        let along = &p.turned[self.turn].axes[0];
        for i in 0..LANES {
            let phase = along[i] * self.per_metre + f64::from(bend[i]) * 1.3;
            let share = (phase - nearest(phase).1) as f32 + 0.5;
            let tall = (0.6 + 1.1 * vigour[i]).clamp(0.0, 1.0);
            own[i] *= self.amplitude_m as f32 * tall * ridge(share);
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (0.0, self.amplitude_m)
    }
}

impl Dunes {
    /// How much of the ground is dunes, 0 to 1; nothing where that is 0 throughout.
    #[inline(always)]
    pub(crate) fn mask(&self, p: &Points, base: &Lane) -> Option<Lane> {
        // Where the ground faces the wind's axis ridges would be as wide as the planet.
        const LEVEL: Ramp = Ramp::new([0.25, 0.6]);
        let mut mask = self.regions.mask(p, base)?;
        let along = &p.turned[self.turn].axes[0];
        for i in 0..LANES {
            let facing = (along[i] * self.per_radius) as f32;
            mask[i] *= LEVEL.at(1.0 - facing * facing);
        }
        Some(mask)
    }

    /// Whether these are dunes with sand of their own colour; ripples are of the ground's.
    pub(crate) fn coloured(&self) -> bool {
        self.per_metre * RIPPLES_M < 1.0
    }
}

/// Height of a dune, 0 at both feet and 1 at the crest: concave up the wind, then a straight slip face.
#[inline(always)]
fn ridge(share: f32) -> f32 {
    let (up, down) = (share * (1.0 / WINDWARD), (1.0 - share) * (1.0 / (1.0 - WINDWARD)));
    let up = up * (0.45 + 0.55 * up);
    up.min(down).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dunes_meet_the_ground_at_their_feet() {
        assert_eq!((ridge(0.0), ridge(1.0)), (0.0, 0.0));
        assert!((ridge(WINDWARD) - 1.0).abs() < 1e-5 && ridge(0.4) < ridge(0.6) && ridge(0.9) < ridge(0.8));
    }
}
