//! Canyons: valleys along the crests of a ridged multifractal (Musgrave 1994), turned upside down, so that side valleys branch off
//! the main ones; flat floors, steep walls in steps. In: a chunk of points in metres and the base elevation. Out: metres of the
//! layer's own at each point, never above 0, or nothing where there are none in the whole chunk.

use super::layer::{Evaluate, Past};
use super::noise::mix;
use super::octaves::{Fractal, Warp};
use super::points::{Lane, Points, LANES};
use super::regions::Regions;
use crate::recipe::{self, Recipe, RecipeError};

/// Ledges on the way down a wall.
const LEDGES: i32 = 5;

/// One layer of canyons.
pub(crate) struct Canyons {
    lines: Fractal,
    warp: Option<Warp>,
    regions: Regions,
    /// Value of the lines where a wall begins, and one over how much more they have at its foot.
    rim: f32,
    per_wall: f32,
    ledges: f32,
    depth_m: f64,
}

impl Evaluate for Canyons {
    type Recipe = recipe::Canyons;

    fn new(seed: u64, recipe: &recipe::Canyons, _: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            lines: Fractal::new(seed, &recipe.octaves),
            warp: Warp::new(mix(seed ^ 1), recipe.octaves.wavelength_m, recipe.warp_m, 3),
            regions: Regions::new(mix(seed ^ 2), &recipe.regions),
            rim: (1.0 - recipe.width) as f32,
            per_wall: (1.0 / (recipe.width * recipe.wall)) as f32,
            ledges: recipe.ledges as f32,
            depth_m: recipe.depth_m,
        })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        let mask = self.regions.mask(p, &past.base)?;
        let mut room = None;
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        let mut own = self.lines.ridged(p);
        for i in 0..LANES {
            // Towards the ends of its region a canyon gets shallower and narrower alike.
            let down = ((own[i] * mask[i] - self.rim) * self.per_wall).clamp(0.0, 1.0);
            own[i] = -self.depth_m as f32 * mask[i] * (down + (stairs(down) - down) * self.ledges);
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (-self.depth_m, 0.0)
    }
}

/// A rise from 0 to 1 over 0 to 1 in [`LEDGES`] steps, each level at first.
#[inline(always)]
pub(super) fn stairs(t: f32) -> f32 {
    let mut sum = 0.0;
    for ledge in 0..LEDGES {
        sum += ((t * LEDGES as f32 - ledge as f32) * 2.5 - 1.5).clamp(0.0, 1.0);
    }
    sum * (1.0 / LEDGES as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stairs_are_continuous_and_meet_their_ends() {
        let steps: Vec<f32> = (0..=1000).map(|i| stairs(i as f32 * 1e-3)).collect();
        assert_eq!((steps[0], steps[1000]), (0.0, 1.0));
        assert!(steps.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] < 4e-3), "steps of a thousandth");
        assert!(steps.windows(2).filter(|w| w[0] == w[1]).count() > 500, "no ledges");
    }
}
