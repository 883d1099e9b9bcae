//! Coasts where a picture of the whole planet has them, and a sea floor where it shows water. In: a picture. Out: ground that comes down to
//! the sea at its coasts; beyond them shelf, slope and abyss by the distance from the coast.

mod coast;

use super::grid::Grid;
use super::heightmap::footprint::Footprint;
use super::heightmap::smoothstep;
use super::imagery::{picture, water};
use super::layer::{Evaluate, Past};
use super::noise::mix;
use super::octaves::Fractal;
use super::points::{Lane, Points, WideLane, LANES};
use super::profile::Profile;
use crate::recipe::{self, Octaves, Placement, Recipe, RecipeError};

/// How far from coasts they still stray, in lengths by which they do.
const STRAY: f64 = 5.0;

/// Shortest wiggle of a coast, in metres.
const WIGGLE_M: f64 = 50.0;

/// Distance from the coast over which the land is taken for dry, whatever its height, in metres.
const DRY_M: f64 = 2e3;

/// Coasts and the sea floor.
pub(crate) struct Seabed {
    coast: Grid,
    footprint: Footprint,
    stray: Option<Fractal>,
    ragged_m: f64,
    /// Height by the distance from the coast.
    profile: Profile,
    shore_m: f64,
    level_m: f64,
    radius: f64,
}

impl Evaluate for Seabed {
    type Recipe = recipe::Seabed;

    fn new(seed: u64, seabed: &recipe::Seabed, planet: &Recipe) -> Result<Self, RecipeError> {
        let photo = picture(&seabed.file, planet)?;
        let footprint = Footprint::new(&photo.green, &Placement::Planet, planet.radius)
            .map_err(|(found, expected)| planet.picture_error(&seabed.file, found, &expected))?;
        let mut is_water: Vec<bool> = photo.pixels.iter().map(|&pixel| water::is_blue(pixel)).collect();
        let (size, profile) = (photo.size(), profile(seabed));
        water::drop_small(&mut is_water, size, planet.radius, seabed.smallest_km2 * 1e6);
        let most_m = 2.0 * (seabed.shelf_m + seabed.slope_m + ABYSS * seabed.slope_m + STRAY * seabed.ragged_m);
        let values = coast::distances(&is_water, size, planet.radius, most_m as f32);
        let run = Octaves { wavelength_m: 4.0 * seabed.ragged_m, detail_m: WIGGLE_M, gain: 0.55 };
        Ok(Self {
            coast: Grid { size, values, wraps: true },
            footprint,
            stray: (seabed.ragged_m > WIGGLE_M).then(|| Fractal::new(mix(seed ^ 1), &run)),
            ragged_m: seabed.ragged_m,
            profile,
            shore_m: seabed.shore_m,
            level_m: planet.sea.as_ref().map_or(0.0, |sea| sea.level_m),
            radius: planet.radius,
        })
    }

    fn is_base(&self) -> bool {
        true
    }

    /// It adds nothing: it replaces what there is.
    #[inline(always)]
    fn metres(&self, _: &Points, _: &mut Past) -> Option<Lane> {
        None
    }

    #[inline(always)]
    fn compose(&self, p: &Points, past: &mut Past, mut height: Option<&mut WideLane>) {
        let inland = self.inland(p);
        let own = self.profile.lanes(&inland);
        for i in 0..LANES {
            let share = smoothstep([0.0, self.shore_m], f64::from(inland[i]));
            let ground = |before: f64| self.level_m + f64::from(own[i]) + (before - self.level_m).max(0.0) * share;
            past.base[i] = ground(f64::from(past.base[i])) as f32;
            past.relief[i] *= share as f32;
            if let Some(height) = height.as_deref_mut() {
                height[i] = ground(height[i]);
            }
        }
    }

    /// Land stays dry where later layers dig into it.
    #[inline(always)]
    fn dry(&self, p: &Points) -> Option<Lane> {
        let mut dry = self.inland(p);
        for v in &mut dry {
            *v = (0.5 + *v * (1.0 / DRY_M) as f32).clamp(0.0, 1.0);
        }
        Some(dry)
    }

    fn lowest_dry(&self) -> Option<f64> {
        Some(self.level_m)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        self.profile.range()
    }

    fn bound(&self, (_, high): (f64, f64)) -> (f64, f64) {
        let (low, land) = self.profile.range();
        (self.level_m + low, self.level_m + land + (high - self.level_m).max(0.0))
    }
}

impl Seabed {
    /// Metres from the coast, above 0 on land.
    #[inline(always)]
    fn inland(&self, p: &Points) -> Lane {
        let mut inland = [0.0; LANES];
        for i in 0..LANES {
            let spot = self.footprint.locate([0, 1, 2].map(|k| p.position[k][i] / self.radius));
            inland[i] = spot.map_or(0.0, |spot| self.coast.at(spot.column, spot.row));
        }
        let reach = (STRAY * self.ragged_m) as f32;
        let Some(stray) = &self.stray else { return inland };
        if inland.iter().all(|m| m.abs() >= reach) {
            return inland;
        }
        let noise = stray.brownian(p);
        for i in 0..LANES {
            let far = inland[i] / reach;
            let near = (1.0 - far * far).max(0.0);
            inland[i] += self.ragged_m as f32 * noise[i] * near * near;
        }
        inland
    }
}

/// Width of the way from the foot of the slope down to the abyss, in widths of the slope.
const ABYSS: f64 = 6.0;

/// The shelf's first part, in widths of the shelf, and how deep it goes down, in depths of its edge: from far off shallows are a line.
const EDGE: f64 = 0.03;
const EDGE_DEPTH: f64 = 0.35;

/// Metres above the sea by the distance from the coast.
fn profile(seabed: &recipe::Seabed) -> Profile {
    let (shelf, slope) = (seabed.shelf_m, seabed.shelf_m + seabed.slope_m);
    Profile::new(&[
        [-slope - ABYSS * seabed.slope_m, -seabed.abyss_depth_m],
        [-slope, -seabed.slope_depth_m],
        [-shelf, -seabed.shelf_depth_m],
        [-EDGE * shelf, -EDGE_DEPTH * seabed.shelf_depth_m],
        [0.0, 0.0],
        [seabed.shore_m, seabed.land_m],
    ])
}
