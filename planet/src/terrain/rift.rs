//! A rift valley where the recipe puts it: a trough of great length with walls of spurs and gullies, and slumps and hills on its floor.
//! In: a chunk of points in metres. Out: metres of the layer's own, or nothing where there is none in the whole chunk.

use super::canyons::stairs;
use super::layer::{Evaluate, Past};
use super::local_frame::LocalFrame;
use super::noise::mix;
use super::octaves::{Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};

/// How far the trough wanders to either side, in widths.
const WANDER: f32 = 0.55;
/// How much wider than its width it gets.
const SWELL: f32 = 1.1;
/// How deep gullies cut back into the rim, in widths of the wall.
const GULLIES: f32 = 2.0;

/// One rift.
pub(crate) struct Rift {
    frame: LocalFrame,
    /// Bends it as a whole.
    wander: Fractal,
    /// Widens and narrows it.
    breadth: Fractal,
    /// Spurs and gullies.
    gullies: Fractal,
    /// Hills and slumps on the floor.
    slumps: Fractal,
    half_length_m: f32,
    half_width_m: f32,
    wall_m: f32,
    depth_m: f64,
    ledges: f32,
}

impl Evaluate for Rift {
    type Recipe = recipe::Rift;

    fn new(seed: u64, recipe: &recipe::Rift, planet: &Recipe) -> Result<Self, RecipeError> {
        // Walls stand at about 27 degrees.
        let wall_m = (2.0 * recipe.depth_m).min(0.3 * recipe.width_m);
        Ok(Self {
            frame: LocalFrame::new(recipe.latitude_deg, recipe.longitude_deg, recipe.heading_deg, planet.radius),
            wander: Fractal::few(mix(seed ^ 1), recipe.length_m * 0.22, 5),
            breadth: Fractal::few(mix(seed ^ 2), recipe.width_m * 2.2, 6),
            gullies: Fractal::few(mix(seed ^ 3), wall_m * 2.6, 8),
            slumps: Fractal::few(mix(seed ^ 4), recipe.width_m * 0.45, 9),
            half_length_m: (0.5 * recipe.length_m) as f32,
            half_width_m: (0.5 * recipe.width_m) as f32,
            wall_m: wall_m as f32,
            depth_m: recipe.depth_m,
            ledges: recipe.ledges as f32,
        })
    }

    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        const AWAY: Ramp = Ramp::new([0.8, 2.2]);
        let mut own = self.within(p)?;
        let slumps = self.slumps.brownian(p);
        for i in 0..LANES {
            let down = own[i].clamp(0.0, 1.0);
            let stepped = down + (stairs(down) - down) * self.ledges;
            // Slumps and mounds of layered rock stand on the floor.
            let fill = 0.4 * (slumps[i] + 0.12).clamp(0.0, 1.0) * AWAY.at(own[i]);
            own[i] = -self.depth_m as f32 * (stepped - fill);
        }
        Some(past.deepen(own))
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (-self.depth_m, 0.0)
    }
}

impl Rift {
    /// How much of the ground is the rift's floor, 0 to 1; nothing where there is none.
    #[inline(always)]
    pub(crate) fn floor(&self, p: &Points) -> Option<Lane> {
        const FLOOR: Ramp = Ramp::new([0.7, 1.5]);
        Some(FLOOR.lanes(&self.within(p)?))
    }

    /// How far inside of the rim each point is, if any is.
    #[inline(always)]
    fn within(&self, p: &Points) -> Option<Lane> {
        let [up, across, along] = self.frame.lanes(p);
        let reach = self.half_width_m * (1.0 + SWELL + 2.0 * WANDER) + GULLIES * self.wall_m;
        let near = |i: usize| up[i] > 0.0 && across[i].abs() < reach && along[i].abs() < self.half_length_m;
        if !(0..LANES).any(near) {
            return None;
        }
        let inside = self.inside(p, &up, &across, &along);
        if inside.iter().all(|&x| x <= 0.0) {
            return None;
        }
        Some(inside)
    }

    /// How far inside of the rim each point is, in widths of the wall: 0 and less outside.
    #[inline(always)]
    fn inside(&self, p: &Points, up: &Lane, across: &Lane, along: &Lane) -> Lane {
        const ENDS: Ramp = Ramp::new([0.0, 0.28]);
        let (wander, breadth) = (self.wander.brownian(p), self.breadth.brownian(p));
        let gullies = self.gullies.sum(p, |n| n.abs());
        let mut inside = [0.0; LANES];
        for i in 0..LANES {
            let off = (across[i] + wander[i].clamp(-1.0, 1.0) * (2.0 * WANDER * self.half_width_m)).abs();
            let end = ENDS.at(1.0 - along[i].abs() / self.half_length_m);
            let half = self.half_width_m * end * (1.0 + SWELL * breadth[i].clamp(-1.0, 1.0));
            let from_rim = (half - off) / self.wall_m - (gullies[i] - 0.35) * GULLIES * end - 1.2 * (1.0 - end);
            inside[i] = if up[i] > 0.0 { from_rim } else { -1.0 };
        }
        inside
    }
}
