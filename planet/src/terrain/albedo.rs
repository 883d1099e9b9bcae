//! The ground's colour: climate, height, slope and noise through the recipe's palette. In: directions with height and
//! slope. Out: sRGB-encoded albedo. Deterministic like the heights: textures are part of a patch's bytes.

use super::angles::sin_cos;
use super::desert::Winds;
use super::noise::{mix, noise_at};
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{axes, Lane, Points, LANES};
use super::{GroundPoint, Terrain};
use crate::recipe::{Airless, Colour, Living, Octaves, Palette};

/// Noise at the scales on which ground varies.
pub(crate) struct Tints {
    /// Moisture, over thousands of kilometres.
    climate: Fractal,
    /// Woods and meadows: tens of kilometres down to one.
    patch: Fractal,
    /// Fields of scree, thickets: hundreds of metres to tens.
    thicket: Fractal,
    /// Stones and tufts: tens of metres to one or two.
    tuft: Fractal,
    /// Seed and thickness in metres of rock strata.
    strata: (u32, f32),
    /// Sine of the latitude where the snow line reaches 0 m.
    polar_sine: f64,
    /// What only a desert has.
    winds: Option<Winds>,
}

impl Tints {
    pub(crate) fn new(seed: u64, palette: &Palette) -> Self {
        let (climate_m, patch_m, polar_deg) = match palette {
            Palette::Living(l) => (l.climate_m, l.patch_m, l.polar_deg),
            Palette::Airless(a) => (a.patch_m * 8.0, a.patch_m, 90.0),
            Palette::Desert(d) => (d.climate_m, d.patch_m, 90.0),
        };
        let (strata_m, winds) = match palette {
            Palette::Desert(d) => (d.strata_m, Some(Winds::new(seed, d))),
            Palette::Living(_) | Palette::Airless(_) => (STRATA_M, None),
        };
        Self {
            climate: Fractal::few(mix(seed ^ 11), climate_m, 6),
            patch: Fractal::new(mix(seed ^ 12), &Octaves { wavelength_m: patch_m, detail_m: 900.0_f64.min(patch_m), gain: 0.68 }),
            thicket: Fractal::few(mix(seed ^ 13), 700.0, 5),
            tuft: Fractal::new(mix(seed ^ 14), &Octaves { wavelength_m: 22.0, detail_m: 0.7, gain: 0.64 }),
            strata: (mix(seed ^ 15) as u32, (1.0 / strata_m) as f32),
            polar_sine: sin_cos(polar_deg).0,
            winds,
        }
    }

    /// Bands of rock by height, 0 to 1, on ground that is steep enough to show any; beds lie a little uneven.
    #[inline(always)]
    fn strata(&self, site: &Site, patch: &Lane) -> Lane {
        const SHOWN: Ramp = Ramp::new([0.24, 0.42]);
        let (seed, per_metre) = self.strata;
        let mut bands = SHOWN.lanes(&site.slope);
        if !any_above_zero(&bands) {
            return bands;
        }
        for i in 0..LANES {
            let level = site.height[i] * per_metre + 1.5 * patch[i];
            let thick = noise_at(seed, [level * 0.23, level * 0.11, patch[i]]);
            let thin = noise_at(seed ^ 1, [level, 0.37 * level, 0.3 * patch[i]]);
            bands[i] *= (0.5 + 1.1 * thick + 1.0 * thin).clamp(0.0, 1.0);
        }
        bands
    }
}

/// Thickness of strata where the palette says nothing, in metres.
const STRATA_M: f64 = 45.0;

/// The noises of a chunk.
pub(super) struct Noises {
    pub(super) climate: Lane,
    pub(super) patch: Lane,
    pub(super) thicket: Lane,
    pub(super) tuft: Lane,
    /// Bands of rock, 0 to 1.
    pub(super) strata: Lane,
}

/// What is known of the ground of a chunk besides its noises.
pub(super) struct Site {
    /// Absolute sine of the latitude.
    sine: Lane,
    /// Metres above the datum.
    pub(super) height: Lane,
    /// Metres above the sea.
    above: Lane,
    pub(super) slope: Lane,
}

/// A colour for every lane, one array a channel.
pub(super) type ColourLanes = [Lane; 3];

pub(super) type Rgb = [f32; 3];

pub(super) fn rgb(colour: Colour) -> Rgb {
    axes(|k| colour[k] as f32)
}

#[inline(always)]
pub(super) fn mixed(a: Rgb, b: Rgb, t: f32) -> Rgb {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

#[inline(always)]
pub(super) fn put(out: &mut ColourLanes, i: usize, colour: Rgb, light: f32) {
    for k in 0..3 {
        out[k][i] = colour[k] * light;
    }
}

/// Colours of up to [`LANES`] points; see [`super`] for why wide instructions give the same bits.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn chunk_albedo(terrain: &Terrain, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
    terrain.chunk_albedo(points, albedo);
}

impl Terrain {
    /// sRGB-encoded albedo at each point: `albedo[i]` belongs to `points[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        assert_eq!(points.len(), albedo.len(), "one colour for each point");
        for (points, albedo) in points.chunks(LANES).zip(albedo.chunks_mut(LANES)) {
            chunk_albedo(self, points, albedo);
        }
    }

    #[inline(always)]
    pub(super) fn chunk_albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        let p = self.points(points.len(), |i| points[i].direction);
        let tints = &self.tints;
        let site = self.site(points);
        let patch = tints.patch.brownian(&p);
        let noises = Noises {
            climate: tints.climate.brownian(&p),
            strata: if matches!(self.palette, Palette::Airless(_)) { [0.0; LANES] } else { tints.strata(&site, &patch) },
            patch,
            thicket: tints.thicket.brownian(&p),
            tuft: tints.tuft.brownian(&p),
        };
        let mut colours = [[0.0; LANES]; 3];
        match &self.palette {
            Palette::Living(palette) => Paints::new(palette, tints).paint(&site, &noises, &mut colours),
            Palette::Airless(palette) => self.paint_airless(palette, &site, &p, &noises, &mut colours),
            Palette::Desert(palette) => {
                if let Some(winds) = &tints.winds {
                    self.paint_desert((palette, winds), &site, &p, &noises, &mut colours);
                }
            }
        }
        let mut bytes = [[0; 3]; LANES];
        for k in 0..3 {
            for i in 0..LANES {
                bytes[i][k] = (colours[k][i] + 0.5).clamp(0.0, 255.0) as u8;
            }
        }
        albedo.copy_from_slice(&bytes[..albedo.len()]);
    }

    #[inline(always)]
    fn site(&self, points: &[GroundPoint]) -> Site {
        let sea = self.sea_level.unwrap_or(-1e9);
        let mut site = Site { sine: [0.0; LANES], height: [0.0; LANES], above: [0.0; LANES], slope: [0.0; LANES] };
        for (i, point) in points.iter().enumerate().take(LANES) {
            site.sine[i] = point.direction.z.abs() as f32;
            site.height[i] = point.height as f32;
            site.above[i] = (point.height - sea) as f32;
            site.slope[i] = point.slope as f32;
        }
        site
    }

    #[inline(always)]
    fn paint_airless(&self, palette: &Airless, site: &Site, p: &Points, noises: &Noises, out: &mut ColourLanes) {
        const STEEP: Ramp = Ramp::new([0.4, 1.0]);
        const FLOW: Ramp = Ramp::new([-0.03, 0.03]);
        // Hills stand out of the lava about its shores, and it runs into hollows.
        const RELIEF: f32 = 0.3;
        let old = Ramp::new(palette.mare_m);
        let [mare, highland, ray] = [palette.mare, palette.highland, palette.ray].map(rgb);
        let base = self.compose(p, None);
        let mut rays = [0.0; LANES];
        for craters in self.craters() {
            craters.add_rays(p, &mut rays);
        }
        for i in 0..LANES {
            let (climate, patch) = (noises.climate[i], noises.patch[i]);
            let fine = 0.025 * noises.thicket[i] + 0.04 * noises.tuft[i];
            // Flows of two lavas, one redder and brighter, with sharp fronts.
            let flow = FLOW.at(climate + 0.22 * patch);
            let lava = [mare[0] * (0.94 + 0.10 * flow), mare[1] * (0.945 + 0.085 * flow), mare[2] * (0.96 + 0.05 * flow)];
            let ground = mixed(lava, highland, old.at(base[i] + RELIEF * (site.height[i] - base[i])));
            // Steep ground sheds its dark, weathered skin.
            let fresh = rays[i].min(1.0).max(0.35 * STEEP.at(site.slope[i]));
            put(out, i, mixed(ground, ray, fresh), 1.0 + 0.03 * climate + 0.045 * patch + fine);
        }
    }
}

/// The colours and thresholds of a living world, ready to paint with.
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
            bare: Ramp::new([palette.rock_slope[1], palette.rock_slope[1] * 1.8]),
        }
    }

    #[inline(always)]
    fn paint(&self, site: &Site, noises: &Noises, out: &mut ColourLanes) {
        for i in 0..LANES {
            let own = [noises.climate[i], noises.patch[i], noises.thicket[i], noises.tuft[i], noises.strata[i]];
            let above = site.above[i];
            let ground = self.ground([site.sine[i], site.height[i], site.slope[i]], own);
            let land = self.land(&ground, above, own);
            let floor = self.sea_floor(above.min(0.0), own[1]);
            let colour = if above < 0.0 { floor } else { land };
            put(out, i, colour, 1.0 + 0.06 * own[1] + 0.08 * own[2] + 0.13 * own[3]);
        }
    }

    #[inline(always)]
    fn sea_floor(&self, above: f32, patch: f32) -> Rgb {
        let depth = -above * (1.0 + 0.2 * patch);
        let deep = depth / (depth + 250.0);
        mixed(mixed(self.beach, self.shelf, (depth * (1.0 / 12.0)).clamp(0.0, 1.0)), self.abyss, deep)
    }

    #[inline(always)]
    fn ground(&self, [sine, height, slope]: [f32; 3], [climate, patch, thicket, tuft, _]: [f32; 5]) -> Ground {
        const ARID: Ramp = Ramp::new([0.08, 0.56]);
        const WOODED: Ramp = Ramp::new([0.0, 0.55]);
        const WET: Ramp = Ramp::new([-0.45, 0.25]);
        const BOREAL: Ramp = Ramp::new([0.72, 0.95]);
        const TREE_LINE: Ramp = Ramp::new([-500.0, 150.0]);
        const ALPINE: Ramp = Ramp::new([-500.0, 500.0]);
        const SNOW: Ramp = Ramp::new([-180.0, 260.0]);
        // Dry belts near 24 degrees, wet about the equator and from 45 degrees on.
        let off = (sine - 0.41) * (1.0 / 0.24);
        let belt = (1.0 - off * off).max(-0.7);
        let dry = 0.42 * belt - 0.95 * climate + 0.12 * patch - 0.04;
        let cold = sine * self.per_polar_sine;
        // Thickets are small and dense in one landscape, and hardly there in the next.
        let clump = thicket * (0.55 + 1.3 * patch).clamp(0.1, 1.3);
        let line = self.snow_line_m * (1.0 - cold * cold) + 500.0 * climate + 420.0 * patch + 150.0 * thicket;
        let height = height + 12.0 * tuft;
        let over_trees = height - (line - self.tree_drop_m);
        let woods = 0.3 - 1.3 * dry + 0.75 * patch + 0.35 * clump + 0.2 * tuft + 1.0 * (slope - 0.1).min(0.4);
        let steep = slope * (1.0 + 0.25 * thicket + 0.3 * tuft);
        Ground {
            arid: ARID.at(dry),
            tropical: (1.0 - sine * 2.2).max(0.0),
            boreal: BOREAL.at(cold),
            wooded: WOODED.at(woods) * (1.0 - TREE_LINE.at(over_trees + 250.0 * thicket + 600.0 * slope)),
            wet: WET.at(-dry + 0.3 * thicket),
            alpine: ALPINE.at(over_trees),
            // Steep ground holds snow from higher up.
            snow: SNOW.at(height - line + 40.0 * tuft - 500.0 * slope) * (1.0 - self.bare.at(steep)),
            rocky: self.rocky.at(steep),
        }
    }

    #[inline(always)]
    fn land(&self, ground: &Ground, above: f32, [climate, patch, thicket, tuft, strata]: [f32; 5]) -> Rgb {
        const WORN: Ramp = Ramp::new([0.1, 0.8]);
        const STONY: Ramp = Ramp::new([-0.45, 0.6]);
        const INLAND: Ramp = Ramp::new([0.4, 1.0]);
        const THIN: Ramp = Ramp::new([0.0, 0.7]);
        let grass = mixed(self.dry, self.lush, ground.wet);
        let [warm, cool] = [ground.tropical, ground.boreal];
        // Rain forest is greener, taiga darker and bluer.
        let trees = [1.0 - 0.12 * warm - 0.2 * cool, 1.0 + 0.12 * warm - 0.12 * cool, 1.0 - 0.15 * warm];
        let trees = axes(|k| self.forest[k] * trees[k]);
        let meadow = mixed(grass, trees, ground.wooded * 0.9);
        // Clearings, worn ground and dead grass, from hundreds of metres down to tufts, least in wet woods.
        let worn = WORN.at(0.6 * thicket + 0.7 * tuft) * (0.45 + 0.9 * patch).clamp(0.08, 0.6);
        let meadow = mixed(meadow, self.dry, worn * (1.0 - 0.6 * ground.wooded * ground.wet));
        // Sand, red stone, and dark gravel plains between them.
        let stony = STONY.at(0.6 * patch + 0.6 * climate + 0.25 * thicket + 0.3);
        let gravel = (1.0 - (patch + 0.35 * climate + 0.1).abs() * 3.2 + 0.4 * thicket).clamp(0.0, 0.4);
        let sand = mixed(mixed(self.desert, self.badland, 0.7 * stony), self.rock, gravel);
        let soil = mixed(mixed(meadow, sand, ground.arid), self.tundra, ground.alpine * (1.0 - 0.5 * ground.arid));
        let shore = 1.0 - INLAND.at(above * self.per_beach_m + 0.25 * thicket + 0.1 * tuft);
        let soil = mixed(soil, self.beach, shore);
        let rock = mixed(self.rock, self.badland, (0.2 + 0.5 * ground.arid) * strata + 0.2 * ground.arid);
        // High ground wears thin even where it is level.
        let bare = ground.rocky.max(ground.alpine * THIN.at(thicket + 0.6 * patch) * 0.6);
        mixed(mixed(soil, rock, bare), self.snow, ground.snow)
    }
}
