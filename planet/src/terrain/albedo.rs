//! The ground's colour: climate, height, slope and noise through the recipe's palette. In: directions with height and
//! slope. Out: sRGB-encoded albedo. Deterministic like the heights: textures are part of a patch's bytes.

use super::desert::Winds;
use super::layer::Step;
use super::living::Biomes;
use super::noise::{mix, noise_at};
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{axes, Lane, Points, LANES};
use super::shores::above_sea;
use super::{GroundPoint, Terrain};
use crate::recipe::{Airless, Colour, Octaves, Palette};
use terrane_heightfield::angles::sin_cos;

/// Noise at the scales on which ground varies.
pub(crate) struct Tints {
    /// Moisture, over thousands of kilometres.
    pub(super) climate: Fractal,
    /// Woods and meadows: tens of kilometres down to one.
    pub(super) patch: Fractal,
    /// Fields of scree, thickets: hundreds of metres to tens.
    pub(super) thicket: Fractal,
    /// Stones and tufts: tens of metres to one or two.
    pub(super) tuft: Fractal,
    /// Seed and thickness in metres of rock strata.
    strata: (u32, f32),
    /// Sine of the latitude where the snow line reaches 0 m.
    pub(super) polar_sine: f64,
    /// What only a desert has.
    winds: Option<Winds>,
    /// What only a living world has.
    biomes: Option<Biomes>,
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
            biomes: if let Palette::Living(palette) = palette { Some(Biomes::new(seed, palette)) } else { None },
        }
    }

    /// Bands of rock by height, 0 to 1, on ground that is steep enough to show any; beds lie a little uneven.
    #[inline(always)]
    pub(super) fn strata(&self, site: &Site, patch: &Lane) -> Lane {
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
    pub(super) sine: Lane,
    /// Metres above the datum.
    pub(super) height: Lane,
    /// Metres above the sea.
    pub(super) above: Lane,
    pub(super) slope: Lane,
    /// How much the ground rises towards the nearer pole.
    pub(super) poleward: Lane,
    /// Metres between neighbouring samples.
    pub(super) spacing: Lane,
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
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
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
        let site = self.site(points, &p);
        let mut colours = [[0.0; LANES]; 3];
        match &self.palette {
            Palette::Living(palette) => {
                if let Some(biomes) = &tints.biomes {
                    self.paint_living((palette, biomes), &site, &p, &mut colours);
                }
            }
            Palette::Airless(palette) => self.paint_airless(palette, &site, &p, &self.noises(&site, &p), &mut colours),
            Palette::Desert(palette) => {
                if let Some(winds) = &tints.winds {
                    self.paint_desert((palette, winds), &site, &p, &self.noises(&site, &p), &mut colours);
                }
            }
        }
        self.paint_imagery(&site, &p, &mut colours);
        let mut bytes = [[0; 3]; LANES];
        for k in 0..3 {
            for i in 0..LANES {
                bytes[i][k] = (colours[k][i] + 0.5).clamp(0.0, 255.0) as u8;
            }
        }
        albedo.copy_from_slice(&bytes[..albedo.len()]);
    }

    #[inline(always)]
    fn noises(&self, site: &Site, p: &Points) -> Noises {
        let tints = &self.tints;
        let patch = tints.patch.brownian(p);
        Noises {
            climate: tints.climate.brownian(p),
            strata: if matches!(self.palette, Palette::Airless(_)) { [0.0; LANES] } else { tints.strata(site, &patch) },
            patch,
            thicket: tints.thicket.brownian(p),
            tuft: tints.tuft.brownian(p),
        }
    }

    /// Puts pictures over the palette's colours, varied by what is finer than they are.
    #[inline(always)]
    fn paint_imagery(&self, site: &Site, p: &Points, colours: &mut ColourLanes) {
        let mut pictures = self.steps.iter().filter_map(|s| if let Step::Imagery(i) = s { Some(i) } else { None }).peekable();
        if pictures.peek().is_none() {
            return;
        }
        let [thicket, tuft] = [&self.tints.thicket, &self.tints.tuft].map(|noise| noise.seen(p, &site.spacing));
        let mut light = [1.0; LANES];
        for i in 0..LANES {
            light[i] += 0.07 * thicket[i] + 0.13 * tuft[i];
        }
        for picture in pictures {
            picture.paint(p, site, &light, colours);
        }
    }

    #[inline(always)]
    fn site(&self, points: &[GroundPoint], p: &Points) -> Site {
        let sea = self.sea_level.unwrap_or(-1e9);
        let [sine, height, above, slope, poleward, spacing] = [[0.0; LANES]; 6];
        let mut site = Site { sine, height, above, slope, poleward, spacing };
        for (i, point) in points.iter().enumerate().take(LANES) {
            site.sine[i] = point.direction.z.abs() as f32;
            site.height[i] = point.height as f32;
            site.above[i] = (point.height - sea) as f32;
            site.slope[i] = point.slope as f32;
            site.poleward[i] = (if point.direction.z < 0.0 { -point.north } else { point.north }) as f32;
            site.spacing[i] = point.spacing as f32;
        }
        if let Some(kept) = self.kept_dry(p).filter(|_| self.sea_level.is_some()) {
            for i in 0..LANES {
                site.above[i] = above_sea(f64::from(site.above[i]), kept[i]) as f32;
            }
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
