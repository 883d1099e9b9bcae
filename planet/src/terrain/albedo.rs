//! The ground's colour: climate, height, slope and noise through the recipe's palette. In: directions with height and
//! slope. Out: sRGB-encoded albedo. Deterministic like the heights: textures are part of a patch's bytes.

use super::angles::sin_cos;
use super::noise::{mix, Lane, Points, LANES};
use super::octaves::{smoothstep, Fractal};
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
    /// Sine of the latitude where the snow line reaches 0 m.
    polar_sine: f64,
}

impl Tints {
    pub(crate) fn new(seed: u64, palette: &Palette) -> Self {
        let (climate_m, patch_m, polar_deg) = match palette {
            Palette::Living(l) => (l.climate_m, l.patch_m, l.polar_deg),
            Palette::Airless(a) => (a.patch_m * 8.0, a.patch_m, 90.0),
        };
        Self {
            climate: Fractal::few(mix(seed ^ 11), climate_m, 6),
            patch: Fractal::new(mix(seed ^ 12), &Octaves { wavelength_m: patch_m, detail_m: 900.0_f64.min(patch_m), gain: 0.68 }),
            thicket: Fractal::few(mix(seed ^ 13), 700.0, 5),
            tuft: Fractal::new(mix(seed ^ 14), &Octaves { wavelength_m: 22.0, detail_m: 0.7, gain: 0.64 }),
            polar_sine: sin_cos(polar_deg).0,
        }
    }
}

/// The noises of a chunk.
struct Noises {
    climate: Lane,
    patch: Lane,
    thicket: Lane,
    tuft: Lane,
}

fn mixed(a: Colour, b: Colour, t: f64) -> Colour {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

fn encode(colour: Colour, light: f64) -> [u8; 3] {
    colour.map(|c| (c * light + 0.5).clamp(0.0, 255.0) as u8)
}

impl Terrain {
    /// sRGB-encoded albedo at each point: `albedo[i]` belongs to `points[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        assert_eq!(points.len(), albedo.len(), "one colour for each point");
        for (points, albedo) in points.chunks(LANES).zip(albedo.chunks_mut(LANES)) {
            let p = self.points(points.iter().map(|g| g.direction));
            let mut noises = Noises { climate: [0.0; LANES], patch: [0.0; LANES], thicket: [0.0; LANES], tuft: [0.0; LANES] };
            self.tints.climate.brownian(&p, &mut noises.climate);
            self.tints.patch.brownian(&p, &mut noises.patch);
            self.tints.thicket.brownian(&p, &mut noises.thicket);
            self.tints.tuft.brownian(&p, &mut noises.tuft);
            match &self.palette {
                Palette::Living(palette) => self.paint_living(palette, points, &noises, albedo),
                Palette::Airless(palette) => self.paint_airless(palette, points, &p, &noises, albedo),
            }
        }
    }

    fn paint_living(&self, palette: &Living, points: &[GroundPoint], noises: &Noises, albedo: &mut [[u8; 3]]) {
        let sea = self.sea_level.unwrap_or(-1e9);
        for (i, (point, out)) in points.iter().zip(albedo).enumerate() {
            let (patch, thicket, tuft) = (noises.patch[i], noises.thicket[i], noises.tuft[i]);
            let above = point.height - sea;
            let light = 1.0 + 0.06 * patch + 0.08 * thicket + 0.13 * tuft;
            *out = if above < 0.0 {
                encode(sea_floor(palette, above, patch), light)
            } else {
                let ground = Ground::new(self, palette, point, [noises.climate[i], patch, thicket, tuft]);
                encode(ground.colour(palette, above), light)
            };
        }
    }

    fn paint_airless(&self, palette: &Airless, points: &[GroundPoint], p: &Points, noises: &Noises, albedo: &mut [[u8; 3]]) {
        let (mut base, mut rays) = ([0.0; LANES], [0.0; LANES]);
        self.base(p, &mut base);
        for craters in self.craters() {
            craters.add_rays(p, &mut rays);
        }
        for (i, (point, out)) in points.iter().zip(albedo).enumerate() {
            let (patch, thicket, tuft) = (noises.patch[i], noises.thicket[i], noises.tuft[i]);
            let old = smoothstep(palette.mare_m, base[i] + 200.0 * patch);
            let ground = mixed(palette.mare, palette.highland, old);
            // Steep ground sheds its dark, weathered skin.
            let fresh = rays[i].min(1.0).max(0.35 * smoothstep([0.35, 0.9], point.slope));
            let light = 1.0 + 0.07 * noises.climate[i] + 0.07 * patch + 0.04 * thicket + 0.06 * tuft;
            *out = encode(mixed(ground, palette.ray, fresh), light);
        }
    }
}

fn sea_floor(palette: &Living, above: f64, patch: f64) -> Colour {
    let depth = -above * (1.0 + 0.2 * patch);
    let deep = depth / (depth + 250.0);
    mixed(mixed(palette.beach, palette.shelf, (depth / 12.0).clamp(0.0, 1.0)), palette.abyss, deep)
}

/// What decides the colour of dry land, each from 0 to 1 unless noted.
struct Ground {
    arid: f64,
    wooded: f64,
    wet: f64,
    alpine: f64,
    snow: f64,
    rocky: f64,
    noises: [f64; 4],
}

impl Ground {
    fn new(terrain: &Terrain, palette: &Living, point: &GroundPoint, noises: [f64; 4]) -> Self {
        let [climate, patch, thicket, tuft] = noises;
        let sine = point.direction.z.abs();
        // Dry belts near 24 degrees, wet about the equator and from 45 degrees on.
        let off = (sine - 0.41) / 0.24;
        let belt = (1.0 - off * off).max(-0.7);
        let dry = 0.42 * belt - 0.95 * climate + 0.12 * patch - 0.04;
        let cold = sine / terrain.tints.polar_sine;
        let line = palette.snow_line_m * (1.0 - cold * cold) + 500.0 * climate + 250.0 * patch + 60.0 * thicket;
        let height = point.height + 12.0 * tuft;
        let trees = line - palette.tree_drop_m;
        let woods = 0.3 - 1.3 * dry + 0.75 * patch + 0.3 * thicket + 0.2 * tuft + 0.8 * (point.slope - 0.1).min(0.4);
        let steep = point.slope * (1.0 + 0.25 * thicket + 0.3 * tuft);
        let hold = 1.0 - smoothstep([palette.rock_slope[1], palette.rock_slope[1] * 1.8], steep);
        Self {
            arid: smoothstep([0.12, 0.48], dry),
            wooded: smoothstep([0.0, 0.55], woods) * (1.0 - smoothstep([-500.0, 150.0], height - trees)),
            wet: smoothstep([-0.45, 0.25], -dry + 0.3 * thicket),
            alpine: smoothstep([-500.0, 500.0], height - trees),
            snow: smoothstep([-250.0, 350.0], height - line) * hold,
            rocky: smoothstep(palette.rock_slope, steep),
            noises,
        }
    }

    fn colour(&self, palette: &Living, above: f64) -> Colour {
        let [climate, patch, thicket, tuft] = self.noises;
        let grass = mixed(palette.dry, palette.lush, self.wet);
        let meadow = mixed(grass, palette.forest, self.wooded * 0.9);
        // Clearings, worn ground and dead grass, from hundreds of metres down to tufts.
        let meadow = mixed(meadow, palette.dry, 0.4 * smoothstep([0.1, 0.8], 0.6 * thicket + 0.7 * tuft));
        let sand =
            mixed(palette.desert, palette.badland, 0.75 * smoothstep([-0.7, 1.0], 0.5 * patch + 0.7 * climate + 0.25 * thicket));
        let soil = mixed(mixed(meadow, sand, self.arid), palette.tundra, self.alpine * (1.0 - 0.5 * self.arid));
        let shore = 1.0 - smoothstep([0.4, 1.0], above / palette.beach_m.max(1e-3) + 0.25 * thicket + 0.1 * tuft);
        let soil = mixed(soil, palette.beach, shore);
        let rock = mixed(palette.rock, palette.badland, 0.55 * self.arid + 0.1);
        // High ground wears thin even where it is level.
        let bare = self.rocky.max(self.alpine * smoothstep([0.0, 0.7], thicket + 0.6 * patch) * 0.6);
        mixed(mixed(soil, rock, bare), palette.snow, self.snow)
    }
}
