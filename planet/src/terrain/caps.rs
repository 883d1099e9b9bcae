//! Polar caps: domes of layered ice with an edge, cut by troughs that spiral out from the poles, each with a steep wall that faces away
//! from the pole (Smith and Holt 2010). In: a chunk of points in metres. Out: metres of the layer's own, how much of the ground is ice, and
//! how much of a trough's wall is bare.

use super::layer::{Evaluate, Past};
use super::noise::{mix, nearest};
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};
use std::f64::consts::TAU;
use terrane_heightfield::angles::{atan2, sin_cos};

/// Troughs that a circle about the pole crosses. Whole, so that the spirals close.
const ARMS: f64 = 7.0;
/// Share of a trough's width that is its steep wall.
const WALL: f32 = 0.17;

/// The caps of both poles.
pub(crate) struct Caps {
    /// One over the distance of the edge from the axis, in 1/m.
    per_edge: f64,
    /// Troughs from pole to edge along a meridian.
    turns: f64,
    /// Frays the edge.
    edge: Fractal,
    /// Bends troughs.
    bend: Fractal,
    /// Ends some and deepens others.
    vigour: Fractal,
    height_m: f64,
    trough_m: f64,
}

/// Where a chunk's points are on a cap.
struct Site {
    /// 0 at the edge, 1 at the pole.
    inward: Lane,
    /// Share of the way across a trough, outwards from its upper edge.
    share: Lane,
    /// How deep troughs are.
    vigour: Lane,
}

impl Evaluate for Caps {
    type Recipe = recipe::Caps;

    fn new(seed: u64, recipe: &recipe::Caps, planet: &Recipe) -> Result<Self, RecipeError> {
        let edge_m = planet.radius * sin_cos(recipe.latitude_deg).1;
        Ok(Self {
            per_edge: 1.0 / edge_m,
            turns: edge_m / recipe.apart_m,
            edge: Fractal::few(mix(seed ^ 1), edge_m * 0.6, 8),
            bend: Fractal::few(mix(seed ^ 2), edge_m * 0.6, 1),
            vigour: Fractal::few(mix(seed ^ 3), edge_m * 0.3, 2),
            height_m: recipe.height_m,
            trough_m: recipe.trough_m,
        })
    }

    /// Ice is younger than most craters: `renewed` says so.
    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        const SCARP: Ramp = Ramp::new([0.0, 0.014]);
        let site = self.site(p)?;
        let mut own = site.inward;
        for i in 0..LANES {
            let x = own[i].clamp(0.0, 1.0);
            past.renewed[i] = past.renewed[i].max(SCARP.at(x));
            let dome = 0.3 * SCARP.at(x) + 0.7 * x * (2.0 - x);
            own[i] = self.height_m as f32 * dome - self.trough_m as f32 * dip(site.share[i]) * site.vigour[i];
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (-self.trough_m, self.height_m)
    }
}

impl Caps {
    /// How much of the ground is ice, and how much of it is a bare wall; nothing far from the caps.
    #[inline(always)]
    pub(crate) fn cover(&self, p: &Points) -> Option<[Lane; 2]> {
        const EDGE: Ramp = Ramp::new([0.004, 0.03]);
        const STEEP: Ramp = Ramp::new([0.35, 0.8]);
        let site = self.site(p)?;
        let bare = |i: usize| {
            let wall = 1.0 - (site.share[i] * (1.0 / (WALL * 1.4)) - 0.5).abs() * 2.0;
            STEEP.at(wall.max(0.0) * 1.6) * (site.vigour[i] * 1.6).min(1.0)
        };
        Some([EDGE.lanes(&site.inward), std::array::from_fn(bare)])
    }

    #[inline(always)]
    fn site(&self, p: &Points) -> Option<Site> {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            let (x, y) = (p.position[0][i] * self.per_edge, p.position[1][i] * self.per_edge);
            out[i] = (x * x + y * y).sqrt() as f32;
        }
        if out.iter().all(|&out| out > 1.5) {
            return None;
        }
        let mut inward = self.edge.brownian(p);
        for i in 0..LANES {
            inward[i] = 1.0 - out[i] + 0.2 * inward[i];
        }
        any_above_zero(&inward).then(|| self.troughs(p, &out, inward))
    }

    #[inline(always)]
    fn troughs(&self, p: &Points, out: &Lane, inward: Lane) -> Site {
        const MIDDLE: Ramp = Ramp::new([0.1, 0.3]);
        const RIM: Ramp = Ramp::new([0.02, 0.12]);
        let (bend, vigour) = (self.bend.brownian(p), self.vigour.brownian(p));
        let (mut share, mut deep) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let around = atan2(p.position[1][i], p.position[0][i]) * (ARMS / TAU);
            let around = if p.position[2][i] < 0.0 { -around } else { around };
            let phase = around + f64::from(out[i]) * self.turns + f64::from(bend[i]) * 0.8;
            share[i] = (phase - nearest(phase).1) as f32 + 0.5;
            deep[i] = (0.55 + 1.5 * vigour[i]).clamp(0.0, 1.0) * MIDDLE.at(out[i]) * RIM.at(inward[i]);
        }
        Site { inward, share, vigour: deep }
    }
}

/// Depth of a trough, 0 at both edges and 1 at the foot of its wall: down the wall, then up a long gentle slope.
#[inline(always)]
fn dip(share: f32) -> f32 {
    let (down, up) = (share * (1.0 / WALL), (1.0 - share) * (1.0 / (1.0 - WALL)));
    let d = down.min(up * (0.35 + 0.65 * up)).clamp(0.0, 1.0);
    d * d * (3.0 - 2.0 * d)
}

#[cfg(test)]
mod tests {
    use super::super::layer::planet;
    use super::*;

    #[test]
    fn troughs_are_continuous_and_have_one_steep_side() {
        let depth: Vec<f32> = (0..=1000).map(|i| dip(i as f32 * 1e-3)).collect();
        assert_eq!((depth[0], depth[1000]), (0.0, 0.0));
        assert!(depth.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01), "a step");
        let foot = depth.iter().position(|&d| d > 0.999).unwrap();
        assert!((120..260).contains(&foot), "foot at {foot}");
    }

    #[test]
    fn spirals_continue_where_the_angle_starts_again() {
        let recipe = recipe::Caps { latitude_deg: 80.0, height_m: 2000.0, trough_m: 500.0, apart_m: 50e3 };
        let caps = Caps::new(1, &recipe, &planet(3.4e6)).unwrap();
        let at = |x: f64, y: f64, z: f64| {
            let length = (x * x + y * y + z * z).sqrt() / 3.4e6;
            caps.metres(&Points::at([x, y, z].map(|v| [v / length; LANES])), &mut Past::over([0.0; LANES])).map(|own| own[0])
        };
        for z in [3.3e6, -3.3e6] {
            for x in [-1e5, -2e5, -3e5, -4e5] {
                let (Some(a), Some(b)) = (at(x, 0.01, z), at(x, -0.01, z)) else { panic!("no cap at {x}") };
                assert!((a - b).abs() < 0.05, "{a} and {b} at {x}");
            }
        }
        let around = [(1e5, 0.0), (0.0, 1e5), (-1e5, 0.0), (0.0, -1e5)].map(|(x, y)| at(x, y, 3.3e6).unwrap());
        let [low, high] = [f32::min, f32::max].map(|of| around.into_iter().reduce(of).unwrap());
        assert!(high - low > 1.0, "no trough crosses the circle: {around:?}");
        assert!(at(3.4e6, 0.0, 0.0).is_none());
    }
}
