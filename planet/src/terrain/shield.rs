//! Shield volcanoes, where the recipe puts them: long flanks that steepen upwards a little, a scarp at their foot, nested calderas at the
//! top. In: a chunk of points in metres. Out: metres of the layer's own, never below 0, or nothing where there are none in the whole chunk.

use super::layer::{Evaluate, Past};
use super::local_frame::LocalFrame;
use super::noise::mix;
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};

/// Calderas of a top: position in radii of the largest, radius, and depth. They cut into each other.
const CALDERAS: [[f32; 4]; 4] =
    [[0.0, 0.0, 0.9, 0.62], [0.5, 0.42, 0.52, 1.0], [-0.52, 0.5, 0.44, 0.8], [-0.12, -0.62, 0.58, 0.72]];
/// Share of a caldera's radius squared that is wall.
const WALL: f32 = 0.2;

/// How far the foot wanders in and out, in radii.
const WANDER: f32 = 0.3;

/// One volcano.
pub(crate) struct Shield {
    frame: LocalFrame,
    /// Bends its foot.
    bend: Fractal,
    /// Bends the walls of its calderas.
    slumps: Fractal,
    radius_m: f64,
    height_m: f64,
    caldera_m: f64,
    caldera_depth_m: f64,
    scarp: f32,
}

impl Evaluate for Shield {
    type Recipe = recipe::Shield;

    fn new(seed: u64, recipe: &recipe::Shield, planet: &Recipe) -> Result<Self, RecipeError> {
        Ok(Self {
            frame: LocalFrame::new(recipe.latitude_deg, recipe.longitude_deg, 0.0, planet.radius),
            bend: Fractal::few(mix(seed ^ 1), recipe.radius_m * 0.55, 6),
            slumps: Fractal::few(mix(seed ^ 2), recipe.caldera_m.max(1e3) * 0.5, 6),
            radius_m: recipe.radius_m,
            height_m: recipe.height_m,
            caldera_m: recipe.caldera_m,
            caldera_depth_m: recipe.caldera_depth_m,
            scarp: recipe.scarp as f32,
        })
    }

    fn is_base(&self) -> bool {
        true
    }

    /// Its flanks are younger ground: `renewed` says so.
    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        const YOUNG: Ramp = Ramp::new([0.06, 0.3]);
        let mut own = self.frame.distances2(p);
        let reach = self.radius_m / f64::from(1.0 - WANDER) + 1.0;
        if own.iter().all(|&d2| d2 > (reach * reach) as f32) {
            return None;
        }
        let bend = self.bend.brownian(p);
        let per_radius2 = (1.0 / (self.radius_m * self.radius_m)) as f32;
        for i in 0..LANES {
            let out = (own[i] * per_radius2).sqrt();
            // The foot wanders, the top does not.
            let wide = 1.0 + WANDER * bend[i].clamp(-1.0, 1.0) * out.min(1.0);
            let up = (1.0 - out * wide).max(0.0);
            own[i] = self.height_m as f32 * self.flank(up);
            past.renewed[i] = past.renewed[i].max(YOUNG.at(up));
        }
        if self.caldera_m > 0.0 {
            self.add_calderas(p, &mut own);
        }
        any_above_zero(&own).then_some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (0.0, self.height_m)
    }
}

impl Shield {
    /// Height of the flanks, 1 in the middle: `up` is 0 at the foot.
    #[inline(always)]
    fn flank(&self, up: f32) -> f32 {
        const SCARP: Ramp = Ramp::new([0.0, 0.045]);
        self.scarp * SCARP.at(up) + (1.0 - self.scarp) * up * (0.75 + 0.25 * up)
    }

    #[inline(always)]
    fn add_calderas(&self, p: &Points, own: &mut Lane) {
        let [_, east, north] = self.frame.lanes(p);
        let (per_radius, slumps) = ((1.0 / self.caldera_m) as f32, self.slumps.brownian(p));
        let top = self.height_m as f32 * self.flank((1.0 - self.caldera_m / self.radius_m).max(0.0) as f32);
        for i in 0..LANES {
            let (x, y) = (east[i] * per_radius, north[i] * per_radius);
            let mut depth = 0.0_f32;
            for [cx, cy, radius, deep] in CALDERAS {
                let (dx, dy) = ((x - cx) / radius, (y - cy) / radius);
                let t = (dx * dx + dy * dy) * (1.0 + 0.2 * slumps[i]);
                depth = depth.max(deep * ((1.0 - t) * (1.0 / WALL)).clamp(0.0, 1.0));
            }
            // Floors are level: from the rim down, whatever the flank would have been.
            let inside = (depth * (1.0 / 0.6)).min(1.0);
            let level = own[i] + (top.min(own[i]) - own[i]) * inside;
            own[i] = (level - self.caldera_depth_m as f32 * depth).max(0.0);
        }
    }
}
