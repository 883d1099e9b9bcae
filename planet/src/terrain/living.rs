//! Colours of a living world: sea floor, beaches, woods, meadows, steppes, deserts, tundra, rock and snow, by climate, height, slope
//! and noise. In: sites of a chunk. Out: a colour for each point.
//!
//! Samples may stand far apart. Noise finer than that is left out and edges get as wide as the ground between two samples is
//! uneven, so that seen from orbit a landscape has the mean of its colours and not a random one of them.

use super::albedo::{mixed, put, rgb, ColourLanes, Rgb, Site, Tints};
use super::climate::{Climate, Weather};
use super::layer::{Evaluate, Past, Step};
use super::noise::mix;
use super::octaves::{Fractal, Ramp};
use super::points::{axes, Lane, Points, LANES};
use super::Terrain;
use crate::recipe::{Living, Octaves};
use glam::DVec3;
use std::sync::OnceLock;

/// How much longer streaks of sand are than wide: winds blow along parallels, roughly.
const STREAK: f64 = 4.5;

/// What the colours of a living world need besides its palette.
pub(super) struct Biomes {
    /// Kinds of soil and stone, over hundreds of kilometres.
    province: Fractal,
    streaks: Fractal,
    /// Woods, meadows and scrub within a landscape, over kilometres.
    mosaic: Fractal,
    /// How far the edges of climates stray, in metres.
    stray_m: f64,
    climate: OnceLock<Climate>,
}

impl Biomes {
    pub(super) fn new(seed: u64, palette: &Living) -> Self {
        let province_m = palette.climate_m * 0.28;
        let run = Octaves { wavelength_m: palette.patch_m * 0.9, detail_m: palette.patch_m * 0.004, gain: 0.6 };
        let fields = Octaves { wavelength_m: palette.patch_m * 0.085, detail_m: palette.patch_m * 0.005, gain: 0.72 };
        Self {
            mosaic: Fractal::new(mix(seed ^ 33), &fields),
            province: Fractal::few(mix(seed ^ 31), province_m, 7),
            streaks: Fractal::new(mix(seed ^ 32), &run),
            stray_m: palette.patch_m * 0.4,
            climate: OnceLock::new(),
        }
    }

    /// Noise drawn out along parallels, bent a little.
    #[inline(always)]
    fn streaks(&self, p: &Points, bend: &Lane, spacing: &Lane) -> Lane {
        let mut position = p.position;
        for i in 0..LANES {
            position[2][i] = (position[2][i] + f64::from(bend[i]) * 3.0 * self.stray_m) * STREAK;
        }
        let mut spacing = *spacing;
        for v in &mut spacing {
            *v *= STREAK as f32;
        }
        self.streaks.seen(&Points::at(position), &spacing)
    }
}

/// What is known of one point besides the noises.
struct Conditions {
    sine: f32,
    height: f32,
    above: f32,
    slope: f32,
    /// How much the ground rises towards the nearer pole.
    poleward: f32,
    /// How far samples stand apart, 0 where that is metres, 1 where it is many kilometres.
    coarse: f32,
    /// Share of a valley's depth, 1 on its floor.
    valley: f32,
    /// How much of the coast is beach, 0 to 1.
    sandy: f32,
    weather: Weather,
}

/// The noises of one point.
#[derive(Clone, Copy)]
struct Own {
    climate: f32,
    province: f32,
    patch: f32,
    streak: f32,
    mosaic: f32,
    thicket: f32,
    tuft: f32,
    strata: f32,
}

impl Terrain {
    #[inline(always)]
    pub(super) fn paint_living(&self, (palette, biomes): (&Living, &Biomes), site: &Site, p: &Points, out: &mut ColourLanes) {
        let tints = &self.tints;
        let climate = tints.climate.seen(p, &site.spacing);
        let province = biomes.province.seen(p, &site.spacing);
        let patch = tints.patch.seen(p, &site.spacing);
        let streak = biomes.streaks(p, &climate, &site.spacing);
        let mosaic = biomes.mosaic.seen(p, &site.spacing);
        let thicket = tints.thicket.seen(p, &site.spacing);
        let tuft = tints.tuft.seen(p, &site.spacing);
        let strata = tints.strata(site, &patch);
        let grid = biomes.climate.get_or_init(|| Climate::new(self));
        let mut weather = [Weather::default(); LANES];
        for i in 0..LANES {
            let push = [patch[i] + climate[i], province[i] - patch[i], province[i] - climate[i]];
            weather[i] = grid.at(DVec3::from_array(axes(|k| p.position[k][i] + biomes.stray_m * f64::from(push[k]))));
        }
        let mut mean = [0.0; LANES];
        for i in 0..LANES {
            mean[i] = weather[i].mean_m;
        }
        let valleys = self.valleys(p, &mean);
        let sandy = self.sandy(p);
        let paints = Paints::new(palette, tints);
        for i in 0..LANES {
            let own = Own {
                climate: climate[i],
                province: province[i],
                patch: patch[i],
                streak: streak[i],
                mosaic: mosaic[i],
                thicket: thicket[i],
                tuft: tuft[i],
                strata: strata[i],
            };
            let here = Conditions {
                sine: site.sine[i],
                height: site.height[i],
                above: site.above[i],
                slope: site.slope[i],
                poleward: site.poleward[i],
                coarse: site.spacing[i] / (site.spacing[i] + 1500.0),
                valley: valleys[i],
                sandy: sandy[i],
                weather: weather[i],
            };
            let colour = paints.colour(&here, &own);
            put(out, i, colour, 1.0 + 0.05 * own.patch + 0.07 * own.thicket + 0.13 * own.tuft);
        }
    }

    /// How deep in a river's valley each point is, 0 to 1.
    #[inline(always)]
    fn valleys(&self, p: &Points, base: &Lane) -> Lane {
        let (mut deepest, mut past) = ([0.0; LANES], Past::over(*base));
        for step in &*self.steps {
            let Step::Canyons(canyons) = step else { continue };
            let Some(own) = canyons.metres(p, &mut past) else { continue };
            let per_depth = (1.0 / canyons.range(0.0).0.min(-1e-3)) as f32;
            for i in 0..LANES {
                deepest[i] = (own[i] * per_depth).max(deepest[i]);
            }
        }
        deepest
    }
}

/// The colours and thresholds, ready to paint with.
struct Paints {
    shelf: Rgb,
    abyss: Rgb,
    beach: Rgb,
    lush: Rgb,
    dry: Rgb,
    forest: Rgb,
    desert: Rgb,
    badland: Rgb,
    tundra: Rgb,
    rock: Rgb,
    snow: Rgb,
    per_polar_sine: f32,
    snow_line_m: f32,
    tree_drop_m: f32,
    per_beach_m: f32,
    /// Slopes over which soil gives way to rock.
    rocky: Ramp,
    /// Slopes over which snow slides off.
    bare: Ramp,
}

/// What decides the colour of dry land, each from 0 to 1.
struct Ground {
    arid: f32,
    /// 1 in the wet tropics, 0 from the middle latitudes on.
    tropical: f32,
    /// 1 where winters are long.
    boreal: f32,
    wooded: f32,
    wet: f32,
    alpine: f32,
    snow: f32,
    rocky: f32,
    /// Banks of rivers and lakes.
    bank: f32,
}

/// A rise from 0 to 1 about `middle` over twice `half`, for widths that are not known beforehand.
#[inline(always)]
fn rise(v: f32, middle: f32, half: f32) -> f32 {
    let t = ((v - middle + half) / (2.0 * half)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Paints {
    #[inline(always)]
    fn new(palette: &Living, tints: &Tints) -> Self {
        Self {
            shelf: rgb(palette.shelf),
            abyss: rgb(palette.abyss),
            beach: rgb(palette.beach),
            lush: rgb(palette.lush),
            dry: rgb(palette.dry),
            forest: rgb(palette.forest),
            desert: rgb(palette.desert),
            badland: rgb(palette.badland),
            tundra: rgb(palette.tundra),
            rock: rgb(palette.rock),
            snow: rgb(palette.snow),
            per_polar_sine: (1.0 / tints.polar_sine) as f32,
            snow_line_m: palette.snow_line_m as f32,
            tree_drop_m: palette.tree_drop_m as f32,
            per_beach_m: (1.0 / palette.beach_m.max(1e-3)) as f32,
            rocky: Ramp::new(palette.rock_slope),
            bare: Ramp::new([palette.rock_slope[1] * 0.75, palette.rock_slope[1] * 1.5]),
        }
    }

    #[inline(always)]
    fn colour(&self, here: &Conditions, own: &Own) -> Rgb {
        let land = self.land(&self.ground(here, own), here, own);
        let floor = self.sea_floor(here.above.min(0.0), here.sandy, own);
        axes(|k| if here.above < 0.0 { floor[k] } else { land[k] })
    }

    #[inline(always)]
    fn sea_floor(&self, above: f32, sandy: f32, own: &Own) -> Rgb {
        let depth = -above * (1.0 + 0.2 * own.patch);
        let deep = depth / (depth + 250.0);
        // Rock and weed reach up to the waterline where there is no beach.
        let edge = mixed(self.shelf, self.beach, sandy * (1.0 - 0.5 * rise(own.thicket, 0.25, 0.2)));
        mixed(mixed(edge, self.shelf, (depth * (1.0 / 12.0)).clamp(0.0, 1.0)), self.abyss, deep)
    }

    #[inline(always)]
    fn ground(&self, here: &Conditions, own: &Own) -> Ground {
        let &Conditions { sine, slope, coarse, weather, .. } = here;
        // Dry belts near 25 degrees, wet about the equator and from 45 degrees on.
        let off = (sine - 0.42) * (1.0 / 0.26);
        let belt = (1.0 - off * off).max(-0.6);
        let over_mean = here.height - weather.mean_m;
        // Rain falls on heights, and runs to the valleys.
        let lifted = (over_mean * (1.0 / 3000.0)).clamp(-0.04, 0.3) + 0.22 * here.valley;
        let dry =
            0.36 * belt + 0.95 * (0.62 - weather.rain) - 0.45 * own.climate - 0.12 * own.province + 0.06 * own.patch - lifted;
        let cold = sine * self.per_polar_sine;
        let line = self.snow_line_m * (1.0 - cold * cold * cold) + 550.0 * (dry - 0.1).clamp(-0.6, 0.9) + 200.0 * own.climate;
        let ragged = 130.0 * own.patch + 90.0 * own.thicket + 45.0 * own.tuft;
        let over_trees = here.height - ragged - (line - self.tree_drop_m) + 500.0 * slope;
        // Clumps of trees stand on moist ground first: hollows, north slopes, banks.
        let clump = own.thicket * (0.6 + 1.2 * own.patch).clamp(0.35, 1.3);
        let woods = 0.2 + 0.25 * (1.0 - 2.2 * sine).max(0.0) - (1.35 * dry).clamp(-0.24, 1.0)
            + 0.85 * own.patch
            + 0.35 * own.province
            + 0.45 * clump
            + 0.22 * own.tuft;
        let woods = woods + 0.5 * here.poleward.clamp(-0.5, 0.5) + 0.8 * (slope - 0.12).clamp(-0.1, 0.3);
        let unseen = weather.rugged_m * (1.0 / 1400.0) * coarse;
        let steep = (slope * slope + unseen * unseen).sqrt() * (1.0 + 0.3 * own.thicket + 0.35 * own.tuft);
        // Slopes that face the pole hold snow longer, steep ones shed it, hollows keep it.
        let snow = here.height + ragged - line + 550.0 * here.poleward.clamp(-0.8, 0.8) - 350.0 * slope.min(1.2);
        Ground {
            arid: rise(dry + 0.05 * own.thicket, 0.42, 0.17),
            tropical: (1.0 - sine * 2.2).max(0.0),
            boreal: rise(cold, 0.84, 0.11),
            wooded: rise(woods, 0.25, 0.1 + 0.25 * coarse) * (1.0 - rise(over_trees, -150.0, 160.0 + 400.0 * coarse)),
            wet: rise(-dry + 0.2 * own.patch + 0.2 * own.thicket, -0.08, 0.36),
            alpine: rise(over_trees, 0.0, 350.0),
            snow: rise(snow, 0.0, 110.0 + 260.0 * coarse) * (1.0 - self.bare.at(steep)),
            rocky: self.rocky.at(steep),
            bank: rise(here.valley + 0.15 * own.thicket, 0.72, 0.16),
        }
    }

    #[inline(always)]
    fn land(&self, ground: &Ground, here: &Conditions, own: &Own) -> Rgb {
        let grass = self.grass(ground, own);
        let trees = self.trees(ground, own);
        let meadow = mixed(grass, trees, ground.wooded);
        let meadow = mixed(meadow, mixed(trees, self.lush, 0.5), 0.7 * ground.bank * (1.0 - ground.alpine));
        let desert = self.waste(ground, here, own);
        // Green lines along rivers, where there is any rain at all.
        let desert = mixed(desert, mixed(self.lush, self.dry, 0.4), 0.55 * ground.bank * (1.0 - rise(own.province, 0.1, 0.3)));
        let heath = mixed(self.tundra, grass, 0.7 * ground.wet * (1.0 - 0.8 * ground.boreal));
        let soil = mixed(mixed(meadow, desert, ground.arid), heath, ground.alpine * (1.0 - 0.7 * ground.arid));
        let soil = mixed(soil, self.shore(here, own), self.beach_share(here, own));
        let rock = mixed(self.rock, self.badland, (0.2 + 0.5 * ground.arid) * own.strata + 0.25 * ground.arid);
        let rock = axes(|k| rock[k] * (1.0 + 0.12 * own.province));
        // High ground wears thin even where it is level.
        let thin = ground.alpine * rise(own.thicket + 0.5 * own.patch, 0.2, 0.35) * 0.7;
        mixed(mixed(soil, rock, ground.rocky.max(thin)), self.snow, ground.snow)
    }

    /// Grass, from lush to dead, with worn ground; heavier soils are browner.
    #[inline(always)]
    fn grass(&self, ground: &Ground, own: &Own) -> Rgb {
        let grass = mixed(self.dry, self.lush, ground.wet);
        let ripe = rise(0.6 * own.patch - 0.8 * own.mosaic + 0.4 * own.thicket - 0.4 * own.province, 0.2, 0.35);
        let grass = mixed(grass, axes(|k| self.dry[k] * [1.06, 1.0, 0.88][k]), 0.45 * ripe);
        let brown = mixed(self.tundra, self.badland, 0.3);
        let grass = mixed(
            grass,
            brown,
            0.4 * rise(own.province - 0.3 * own.patch - 0.7 * own.mosaic, 0.2, 0.3) * (1.0 - 0.5 * ground.wet),
        );
        let worn = rise(0.6 * own.thicket + 0.7 * own.tuft, 0.5, 0.4) * (0.45 + 0.9 * own.patch).clamp(0.08, 0.6);
        mixed(grass, self.dry, worn * (1.0 - 0.75 * ground.wet))
    }

    /// Rain forest is greener, taiga darker and bluer; stands differ.
    #[inline(always)]
    fn trees(&self, ground: &Ground, own: &Own) -> Rgb {
        let [warm, cool] = [ground.tropical, ground.boreal];
        let stand = 1.0 + 0.1 * own.patch + 0.14 * own.mosaic + 0.1 * own.province;
        let tint = [1.0 - 0.1 * warm - 0.16 * cool, 1.0 + 0.1 * warm - 0.12 * cool, 1.0 - 0.15 * warm + 0.05 * cool];
        let open = mixed(self.forest, self.dry, 0.4 * (1.0 - ground.wet));
        // Young woods, glades and broad leaves are brighter than old pines.
        let open = mixed(open, self.lush, 0.4 * rise(own.mosaic + 0.5 * own.thicket - 0.3 * own.patch, 0.25, 0.4));
        axes(|k| open[k] * tint[k] * (if k == 2 { 1.0 } else { stand }))
    }

    /// Seas of sand, stony plains, dark massifs, salt.
    #[inline(always)]
    fn waste(&self, ground: &Ground, here: &Conditions, own: &Own) -> Rgb {
        let over_mean = here.height - here.weather.mean_m;
        let calm = 1.0 - rise(here.weather.rugged_m, 260.0, 160.0);
        let streaky = own.streak * 0.5;
        let sand = mixed(self.desert, self.badland, 0.5 * rise(own.climate + 0.5 * own.province, 0.15, 0.4));
        let sand = axes(|k| sand[k] * (1.0 + 0.1 * streaky + 0.05 * own.patch));
        let gravel = mixed(self.rock, self.badland, (0.35 + 0.4 * own.climate + 0.3 * own.mosaic).clamp(0.05, 0.8));
        let gravel = mixed(gravel, self.desert, (0.42 + 0.5 * streaky + 0.3 * own.patch).clamp(0.05, 0.85));
        let erg = rise(0.9 * own.province + 0.55 * streaky + 0.25 * own.patch + 0.25, 0.12, 0.2) * calm;
        let plain = mixed(gravel, sand, erg);
        // Desert varnish on what stands out.
        let massif = rise(over_mean + 0.6 * here.weather.rugged_m * (0.5 + own.patch), 240.0, 200.0).max(0.25 * (1.0 - calm));
        let dark = axes(|k| self.rock[k] * [0.82, 0.74, 0.68][k]);
        let plain = mixed(plain, mixed(dark, self.badland, 0.35 * rise(own.province, 0.1, 0.4)), 0.85 * massif * ground.arid);
        let salt = axes(|k| 0.35 * self.snow[k] + 0.65 * self.beach[k]);
        let pan = rise(-own.province - 0.5 * own.patch - over_mean * (1.0 / 500.0), 0.74, 0.13);
        mixed(plain, salt, 0.8 * pan * calm * (1.0 - rise(here.slope, 0.06, 0.04)))
    }

    /// Sand on open coasts, gravel and mud elsewhere.
    #[inline(always)]
    fn shore(&self, here: &Conditions, own: &Own) -> Rgb {
        let gravel = mixed(self.rock, self.tundra, 0.5 + 0.5 * own.patch.clamp(-1.0, 1.0));
        mixed(gravel, self.beach, rise(here.sandy, 0.45, 0.2))
    }

    /// How much of the ground is beach: low, flat, where the coast has any; the sand ends raggedly.
    #[inline(always)]
    fn beach_share(&self, here: &Conditions, own: &Own) -> f32 {
        let reach = 0.06 + 0.9 * here.sandy * (1.0 - rise(here.slope, 0.12, 0.08));
        1.0 - rise(here.above * self.per_beach_m + 0.16 * own.thicket + 0.12 * own.tuft, reach, 0.35 * reach + 0.02)
    }
}
