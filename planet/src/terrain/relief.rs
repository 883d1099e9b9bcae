//! The noise layers: continents, mountains, hills, plains. In: a chunk of points in metres and the base elevation. Out:
//! metres of the layer's own at each point, or nothing where it is hidden from the whole chunk.

use super::eroded::Eroded;
use super::layer::{Evaluate, Past};
use super::noise::mix;
use super::octaves::{any_above_zero, Fractal, Ramp, Warp};
use super::points::{Lane, Points, LANES};
use super::profile::Profile;
use super::regions::Regions;
use crate::recipe::{self, Recipe, RecipeError};

/// Oceans and continents.
pub(crate) struct Continents {
    fractal: Fractal,
    warp: Option<Warp>,
    profile: Profile,
    ridges: Option<Fractal>,
    ridge_m: f64,
    /// Noise added for each metre towards the north pole.
    north_per_metre: f64,
}

impl Evaluate for Continents {
    type Recipe = recipe::Continents;

    fn new(seed: u64, recipe: &recipe::Continents, planet: &Recipe) -> Result<Self, RecipeError> {
        let wavelength = recipe.octaves.wavelength_m;
        let ridges = (recipe.ridge_m > 0.0).then(|| Fractal::few(mix(seed ^ 2), wavelength * 0.6, 7));
        Ok(Self {
            fractal: Fractal::new(seed, &recipe.octaves),
            warp: Warp::new(mix(seed ^ 1), wavelength * 0.5, recipe.warp_m, 3),
            profile: Profile::new(&recipe.profile),
            ridges,
            ridge_m: recipe.ridge_m,
            north_per_metre: recipe.north / planet.radius,
        })
    }

    fn is_base(&self) -> bool {
        true
    }

    #[inline(always)]
    fn metres(&self, p: &Points, _: &mut Past) -> Option<Lane> {
        let mut room = None;
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        let mut noise = self.fractal.brownian(p);
        for i in 0..LANES {
            noise[i] += (p.position[2][i] * self.north_per_metre) as f32;
        }
        let mut own = self.profile.lanes(&noise);
        if let Some(ridges) = &self.ridges {
            if own.iter().fold(false, |any, &h| any | (h < RIDGE_FADE_M[1] as f32)) {
                self.add_ridges(ridges, p, &mut own);
            }
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        let (low, high) = self.profile.range();
        let crest = if low < RIDGE_FADE_M[1] { RIDGE_FADE_M[1] + self.ridge_m } else { high };
        (low, high.max(crest.min(high + self.ridge_m)))
    }
}

impl Continents {
    #[inline(always)]
    fn add_ridges(&self, ridges: &Fractal, p: &Points, own: &mut Lane) {
        const FADE: Ramp = Ramp::new(RIDGE_FADE_M);
        let crest = ridges.brownian(p);
        for i in 0..LANES {
            let near = 1.0 - (crest[i].abs() * 4.0).min(1.0);
            own[i] += self.ridge_m as f32 * near * near * (1.0 - FADE.at(own[i]));
        }
    }
}

/// Elevations over which mid-ocean ridges fade out, in metres.
const RIDGE_FADE_M: [f64; 2] = [-3800.0, -2500.0];

/// Mountain ranges.
pub(crate) struct Mountains {
    eroded: Eroded,
    warp: Option<Warp>,
    ranges: Fractal,
    /// How high each stretch of a range stands; breaks closed lines into separate ranges.
    vigour: Fractal,
    above: Ramp,
    /// Local relief over which they grow, in place of ranges.
    relief: Option<Ramp>,
    range_width: f32,
    amplitude_m: f64,
}

impl Evaluate for Mountains {
    type Recipe = recipe::Mountains;

    fn new(seed: u64, recipe: &recipe::Mountains, _: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            eroded: Eroded::new(seed, &recipe.octaves),
            warp: Warp::new(mix(seed ^ 1), recipe.octaves.wavelength_m, recipe.warp_m, 2),
            ranges: Fractal::few(mix(seed ^ 2), recipe.range_m, 5),
            vigour: Fractal::few(mix(seed ^ 3), recipe.range_m * 0.6, 2),
            above: Ramp::new(recipe.above_m),
            relief: recipe.relief_m.map(Ramp::new),
            range_width: recipe.range_width as f32,
            amplitude_m: recipe.amplitude_m,
        })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        let mask = self.mask(p, past)?;
        let mut room = None;
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        let ridges_m = (1.0 - UPLIFT) * self.amplitude_m as f32 / self.eroded.highest();
        let mut scale = mask;
        for v in &mut scale {
            *v *= ridges_m;
        }
        let mut own = self.eroded.metres(p, &scale);
        for i in 0..LANES {
            own[i] += self.amplitude_m as f32 * UPLIFT * mask[i] * mask[i];
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (0.0, self.amplitude_m)
    }
}

impl Mountains {
    /// How much of a range stands where, 0 to 1; nothing where that is 0 throughout.
    #[inline(always)]
    fn mask(&self, p: &Points, past: &Past) -> Option<Lane> {
        const FLANK: Ramp = Ramp::new([0.0, 0.8]);
        let mut mask = self.above.lanes(&past.base);
        if !any_above_zero(&mask) {
            return None;
        }
        if let Some(relief) = self.relief {
            return scaled(mask, relief, past);
        }
        let (ranges, vigour) = (self.ranges.brownian(p), self.vigour.brownian(p));
        for i in 0..LANES {
            let width = self.range_width * (0.7 + 1.2 * vigour[i]).clamp(0.0, 1.0) + 1e-9;
            let flank = FLANK.at(1.0 - ranges[i].abs() / width);
            mask[i] *= flank * (0.55 + 0.9 * vigour[i]).clamp(0.0, 1.0);
        }
        any_above_zero(&mask).then_some(mask)
    }
}

/// A mask times a ramp of the local relief; nothing where that is 0 throughout.
#[inline(always)]
fn scaled(mut mask: Lane, relief: Ramp, past: &Past) -> Option<Lane> {
    for i in 0..LANES {
        mask[i] *= relief.at(past.relief[i]);
    }
    any_above_zero(&mask).then_some(mask)
}

/// Share of a range's height that is a smooth swell under the ridges.
const UPLIFT: f32 = 0.15;

/// Hills, or mounds and gullies.
pub(crate) struct Hills {
    fractal: Fractal,
    regions: Regions,
    /// Local relief over which they grow.
    relief: Option<Ramp>,
    roundness: f32,
    amplitude_m: f64,
}

impl Evaluate for Hills {
    type Recipe = recipe::Hills;

    fn new(seed: u64, recipe: &recipe::Hills, _: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            fractal: Fractal::new(seed, &recipe.octaves),
            regions: Regions::new(mix(seed ^ 1), &recipe.regions),
            relief: recipe.relief_m.map(Ramp::new),
            roundness: recipe.roundness as f32,
            amplitude_m: recipe.amplitude_m,
        })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        let mut mask = self.regions.mask(p, &past.base)?;
        if let Some(relief) = self.relief {
            mask = scaled(mask, relief, past)?;
        }
        let round = self.roundness;
        let plain = 1.0 - round.abs();
        let mut own = self.fractal.sum(p, |n| n * plain + (n.abs() * 2.0 - 0.5).min(1.0) * round);
        for i in 0..LANES {
            own[i] *= self.amplitude_m as f32 * mask[i];
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        let bound = self.amplitude_m * self.fractal.total;
        (-bound, bound)
    }
}

/// Relief everywhere.
pub(crate) struct Plains {
    fractal: Fractal,
    amplitude_m: f64,
}

impl Evaluate for Plains {
    type Recipe = recipe::Plains;

    fn new(seed: u64, recipe: &recipe::Plains, _: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self { fractal: Fractal::new(seed, &recipe.octaves), amplitude_m: recipe.amplitude_m })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, _: &mut Past) -> Option<Lane> {
        let mut own = self.fractal.brownian(p);
        for v in &mut own {
            *v *= self.amplitude_m as f32;
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        let bound = self.amplitude_m * self.fractal.total;
        (-bound, bound)
    }
}
