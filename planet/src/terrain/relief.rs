//! The noise layers: continents, mountains, hills, plains. In: a chunk of points in metres and the base elevation. Out:
//! metres added to the height (and, from continents, to the base).

use super::noise::{mix, Lane, Points, LANES};
use super::octaves::{smoothstep, Fractal, Warp};
use super::profile::Profile;
use crate::recipe;

/// Oceans and continents.
pub(crate) struct Continents {
    fractal: Fractal,
    warp: Option<Warp>,
    profile: Profile,
    ridges: Option<Fractal>,
    ridge_m: f64,
}

impl Continents {
    pub(crate) fn new(seed: u64, recipe: &recipe::Continents) -> Self {
        let wavelength = recipe.octaves.wavelength_m;
        let ridges = (recipe.ridge_m > 0.0).then(|| Fractal::few(mix(seed ^ 2), wavelength * 0.6, 7));
        Self {
            fractal: Fractal::new(seed, &recipe.octaves),
            warp: Warp::new(mix(seed ^ 1), wavelength * 0.5, recipe.warp_m, 3),
            profile: Profile::new(&recipe.profile),
            ridges,
            ridge_m: recipe.ridge_m,
        }
    }

    pub(crate) fn add(&self, p: &Points, out: &mut Lane) {
        let moved = self.warp.as_ref().map(|w| w.apply(p));
        let p = moved.as_ref().unwrap_or(p);
        let mut value = [0.0; LANES];
        self.fractal.brownian(p, &mut value);
        for (o, &v) in out[..p.count].iter_mut().zip(&value) {
            *o += self.profile.at(v);
        }
        if let Some(ridges) = &self.ridges {
            if out[..p.count].iter().any(|&h| h < RIDGE_FADE_M[1]) {
                self.add_ridges(ridges, p, out);
            }
        }
    }

    fn add_ridges(&self, ridges: &Fractal, p: &Points, out: &mut Lane) {
        let mut crest = [0.0; LANES];
        ridges.brownian(p, &mut crest);
        for (o, &v) in out[..p.count].iter_mut().zip(&crest) {
            let near = 1.0 - (v.abs() * 4.0).min(1.0);
            *o += self.ridge_m * near * near * (1.0 - smoothstep(RIDGE_FADE_M, *o));
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let (low, high) = self.profile.range();
        let crest = if low < RIDGE_FADE_M[1] { RIDGE_FADE_M[1] + self.ridge_m } else { high };
        (low, high.max(crest.min(high + self.ridge_m)))
    }
}

/// Elevations over which mid-ocean ridges fade out, in metres.
const RIDGE_FADE_M: [f64; 2] = [-3800.0, -2500.0];

/// Mountain ranges.
pub(crate) struct Mountains {
    fractal: Fractal,
    warp: Option<Warp>,
    ranges: Fractal,
    /// How high each stretch of a range stands; breaks closed lines into separate ranges.
    vigour: Fractal,
    recipe: recipe::Mountains,
}

impl Mountains {
    pub(crate) fn new(seed: u64, recipe: &recipe::Mountains) -> Self {
        Self {
            fractal: Fractal::new(seed, &recipe.octaves),
            warp: Warp::new(mix(seed ^ 1), recipe.octaves.wavelength_m, recipe.warp_m, 2),
            ranges: Fractal::few(mix(seed ^ 2), recipe.range_m, 5),
            vigour: Fractal::few(mix(seed ^ 3), recipe.range_m * 0.6, 2),
            recipe: recipe.clone(),
        }
    }

    pub(crate) fn add(&self, p: &Points, base: &Lane, out: &mut Lane) {
        let mut mask = [0.0; LANES];
        if !above(base, p.count, self.recipe.above_m, &mut mask) {
            return;
        }
        let mut range = [0.0; LANES];
        self.ranges.brownian(p, &mut range);
        let mut vigour = [0.0; LANES];
        self.vigour.brownian(p, &mut vigour);
        for ((m, &r), &v) in mask[..p.count].iter_mut().zip(&range).zip(&vigour) {
            let width = self.recipe.range_width * (0.7 + 1.2 * v).clamp(0.0, 1.0) + 1e-9;
            *m *= smoothstep([0.0, 1.0], 1.0 - r.abs() / width) * (0.55 + 0.9 * v).clamp(0.0, 1.0);
        }
        if mask[..p.count].iter().all(|&m| m <= 0.0) {
            return;
        }
        let moved = self.warp.as_ref().map(|w| w.apply(p));
        let mut ridges = [0.0; LANES];
        self.fractal.ridged(moved.as_ref().unwrap_or(p), &mut ridges);
        for i in 0..p.count.min(LANES) {
            out[i] += self.recipe.amplitude_m * mask[i] * (UPLIFT * mask[i] + (1.0 - UPLIFT) * ridges[i]);
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        (0.0, self.recipe.amplitude_m)
    }
}

/// Share of a range's height that is a smooth swell under the ridges.
const UPLIFT: f64 = 0.12;

/// Hills, or mounds and gullies.
pub(crate) struct Hills {
    fractal: Fractal,
    regions: Fractal,
    /// Region noise over which hills fade in.
    edges: [f64; 2],
    recipe: recipe::Hills,
}

impl Hills {
    pub(crate) fn new(seed: u64, recipe: &recipe::Hills) -> Self {
        let middle = 0.7 - 1.4 * recipe.cover;
        let edges = if recipe.cover >= 1.0 { [-9.0, -8.0] } else { [middle - 0.2, middle + 0.2] };
        Self {
            fractal: Fractal::new(seed, &recipe.octaves),
            regions: Fractal::few(mix(seed ^ 1), recipe.region_m, 3),
            edges,
            recipe: recipe.clone(),
        }
    }

    pub(crate) fn add(&self, p: &Points, base: &Lane, out: &mut Lane) {
        let mut mask = [0.0; LANES];
        if !above(base, p.count, self.recipe.above_m, &mut mask) {
            return;
        }
        let mut value = [0.0; LANES];
        self.regions.brownian(p, &mut value);
        for (m, &v) in mask[..p.count].iter_mut().zip(&value) {
            *m *= smoothstep(self.edges, v);
        }
        if mask[..p.count].iter().all(|&m| m <= 0.0) {
            return;
        }
        let round = self.recipe.roundness;
        let plain = 1.0 - round.abs();
        self.fractal.sum(p, &mut value, |n| n * plain + (n.abs() * 2.0 - 0.5).min(1.0) * round);
        for i in 0..p.count.min(LANES) {
            out[i] += self.recipe.amplitude_m * mask[i] * value[i];
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let bound = self.recipe.amplitude_m * self.fractal.total;
        (-bound, bound)
    }
}

/// Relief everywhere.
pub(crate) struct Plains {
    fractal: Fractal,
    amplitude_m: f64,
}

impl Plains {
    pub(crate) fn new(seed: u64, recipe: &recipe::Plains) -> Self {
        Self { fractal: Fractal::new(seed, &recipe.octaves), amplitude_m: recipe.amplitude_m }
    }

    pub(crate) fn add(&self, p: &Points, out: &mut Lane) {
        let mut value = [0.0; LANES];
        self.fractal.brownian(p, &mut value);
        for (o, &v) in out[..p.count].iter_mut().zip(&value) {
            *o += self.amplitude_m * v;
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let bound = self.amplitude_m * self.fractal.total;
        (-bound, bound)
    }
}

/// Fills `mask` with the share of a layer that its base elevation lets through; false where all of it is 0.
pub(crate) fn above(base: &Lane, count: usize, edges: [f64; 2], mask: &mut Lane) -> bool {
    for (m, &b) in mask[..count].iter_mut().zip(base) {
        *m = smoothstep(edges, b);
    }
    mask[..count].iter().any(|&m| m > 0.0)
}
