//! Lava that has filled low ground to one level: smooth plains with sharp shores and wrinkle ridges (Sharpton and Head 1988). In: a chunk
//! of points in metres and the base elevation. Out: metres of the layer's own, never below 0 but for ridges' noise, or nothing where
//! there is none in the whole chunk.

use super::layer::{Evaluate, Past};
use super::noise::mix;
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};

/// Share of the depth below the lava that still shows: it sags where it is thick.
const SAG: f32 = 0.02;

/// One level of lava.
pub(crate) struct Lava {
    level_m: f32,
    shore_m: f32,
    ridges: Fractal,
    /// Where there are ridges: not everywhere.
    vigour: Fractal,
    ridge_m: f64,
}

impl Evaluate for Lava {
    type Recipe = recipe::Lava;

    fn new(seed: u64, recipe: &recipe::Lava, _: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            level_m: recipe.level_m as f32,
            shore_m: recipe.shore_m as f32,
            ridges: Fractal::few(seed, recipe.ridge_apart_m, 4),
            vigour: Fractal::few(mix(seed ^ 1), recipe.ridge_apart_m * 0.7, 2),
            ridge_m: recipe.ridge_m,
        })
    }

    fn is_base(&self) -> bool {
        true
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        const DEEP: Ramp = Ramp::new([0.3, 2.0]);
        let mut own = [0.0; LANES];
        for i in 0..LANES {
            let depth = self.level_m - past.base[i];
            let x = (depth / self.shore_m).clamp(-1.0, 1.0) + 1.0;
            own[i] = 0.25 * self.shore_m * x * x + (depth - self.shore_m).max(0.0) * (1.0 - SAG);
        }
        if !any_above_zero(&own) {
            return None;
        }
        if self.ridge_m > 0.0 {
            let (crest, vigour) = (self.ridges.brownian(p), self.vigour.brownian(p));
            for i in 0..LANES {
                let near = (1.0 - crest[i].abs() * 9.0).max(0.0);
                // A broad arch, and a narrow crest on one of its sides.
                let arch = 0.5 * near + 0.5 * near * near * near;
                let tall = (0.2 + 1.6 * vigour[i]).clamp(0.0, 1.0);
                own[i] += self.ridge_m as f32 * arch * tall * DEEP.at((self.level_m - past.base[i]) / self.shore_m);
            }
        }
        Some(own)
    }

    fn range(&self, low: f64) -> (f64, f64) {
        (0.0, (f64::from(self.level_m) - low).max(0.0) + f64::from(self.shore_m) + self.ridge_m)
    }
}

#[cfg(test)]
mod tests {
    use super::super::layer::planet;
    use super::*;

    #[test]
    fn lava_fills_hollows_and_spares_hills() {
        let recipe = recipe::Lava { level_m: -1000.0, shore_m: 100.0, ridge_m: 0.0, ridge_apart_m: 100e3 };
        let (lava, p) = (Lava::new(3, &recipe, &planet(1e6)).unwrap(), Points::at([[1e6; LANES]; 3]));
        let at = |base: f32| base + lava.metres(&p, &mut Past::over([base; LANES])).map_or(0.0, |own| own[0]);
        assert_eq!(at(500.0), 500.0);
        assert!((at(-2000.0) + 1000.0).abs() < 30.0 && (at(-5000.0) + 1000.0).abs() < 100.0);
        let rise: Vec<f32> = (0..4000).map(|i| at(i as f32 * 0.5 - 2000.0)).collect();
        assert!(rise.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] < 0.51));
    }
}
