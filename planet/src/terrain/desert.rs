//! Colours of a dry, dusty world: bright dust, dark sand blown into streaks, dunes, layered rock, polar ice. In: sites and noises of
//! a chunk. Out: a colour for each point.

use super::albedo::{mixed, put, rgb, ColourLanes, Noises, Rgb, Site};
use super::angles::sin_cos;
use super::dunes::Dunes;
use super::noise::{mix, noise_at};
use super::octaves::{any_above_zero, Fractal, Ramp};
use super::points::{Lane, Points, LANES};
use super::Terrain;
use crate::recipe::Desert;

/// How much wider than high streaks of dark sand are: winds blow along parallels.
const STREAK: f64 = 3.5;
/// How far the troughs in the ice turn about the pole from edge to middle: tangent of half the angle.
const SPIRAL: f32 = 1.1;

/// What desert colours need besides the palette.
pub(super) struct Winds {
    streaks: Fractal,
    /// Seed of the troughs.
    troughs: u32,
    /// One over the sine of the polar distance of the ice's edge.
    per_edge: f64,
}

impl Winds {
    pub(super) fn new(seed: u64, palette: &Desert) -> Self {
        Self {
            streaks: Fractal::few(mix(seed ^ 21), palette.climate_m * 0.35, 4),
            troughs: mix(seed ^ 22) as u32,
            per_edge: 1.0 / sin_cos(palette.ice_deg).1.max(1e-3),
        }
    }

    /// Noise drawn out along parallels.
    #[inline(always)]
    fn streaks(&self, p: &Points) -> Lane {
        let mut place = p.place;
        for z in &mut place[2] {
            *z *= STREAK;
        }
        self.streaks.brownian(&Points::at(place))
    }
}

/// The colours and thresholds, ready to paint with.
struct Paints {
    dust: Rgb,
    sand: Rgb,
    dune: Rgb,
    rock: Rgb,
    strata: Rgb,
    ice: Rgb,
    rocky: Ramp,
    dark: Ramp,
}

impl Terrain {
    #[inline(always)]
    pub(super) fn paint_desert(
        &self,
        (palette, winds): (&Desert, &Winds),
        site: &Site,
        p: &Points,
        noises: &Noises,
        out: &mut ColourLanes,
    ) {
        let streaks = winds.streaks(p);
        let dunes = self.dune_cover(p);
        let ice = self.ice(winds, p, noises);
        let middle = 0.55 - 1.1 * palette.sand_cover;
        let paints = Paints {
            dust: rgb(palette.dust),
            sand: rgb(palette.sand),
            dune: rgb(palette.dune),
            rock: rgb(palette.rock),
            strata: rgb(palette.strata),
            ice: rgb(palette.ice),
            rocky: Ramp::new(palette.rock_slope),
            dark: Ramp::new([middle - 0.22, middle + 0.22]),
        };
        for i in 0..LANES {
            let own = [noises.climate[i], noises.patch[i], noises.thicket[i], noises.tuft[i], streaks[i]];
            let (soil, dark) = paints.soil(site, i, own);
            let soil = mixed(soil, paints.dune, (0.3 + 0.6 * dark) * dunes[i]);
            let steep = site.slope[i] * (1.0 + 0.2 * own[2] + 0.2 * own[3]);
            let ground = mixed(soil, mixed(paints.rock, paints.strata, noises.strata[i]), paints.rocky.at(steep));
            let light = 1.0 + 0.05 * own[0] + 0.07 * own[1] + 0.05 * own[2] + 0.09 * own[3];
            put(out, i, mixed(ground, paints.ice, ice[i] * (1.0 - 0.7 * paints.rocky.at(steep))), light);
        }
    }

    #[inline(always)]
    fn dune_cover(&self, p: &Points) -> Lane {
        let mut cover = [0.0; LANES];
        if self.dunes().any(Dunes::coloured) {
            let base = self.compose(p, None);
            for mask in self.dunes().filter(|dunes| dunes.coloured()).filter_map(|dunes| dunes.mask(p, &base)) {
                for i in 0..LANES {
                    cover[i] = mask[i].max(cover[i]);
                }
            }
        }
        cover
    }

    /// How much of the ground is ice: caps with ragged edges, cut by troughs that wind about the poles.
    #[inline(always)]
    fn ice(&self, winds: &Winds, p: &Points, noises: &Noises) -> Lane {
        const EDGE: Ramp = Ramp::new([-0.035, 0.035]);
        const TROUGH: Ramp = Ramp::new([0.13, 0.03]);
        let per_axis = winds.per_edge / self.radius;
        let (mut ice, mut x, mut y) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            (x[i], y[i]) = ((p.place[0][i] * per_axis) as f32, (p.place[1][i] * per_axis) as f32);
            let ragged = 0.25 * noises.climate[i] + 0.16 * noises.patch[i] + 0.008 * noises.thicket[i];
            ice[i] = EDGE.at(1.0 - (x[i] * x[i] + y[i] * y[i]).sqrt() + ragged);
        }
        if !any_above_zero(&ice) {
            return ice;
        }
        for i in 0..LANES {
            let out = (x[i] * x[i] + y[i] * y[i]).sqrt().max(1e-4);
            // Turned by an angle that grows with the distance: a turn of tangent t has cosine (1 - t²) / (1 + t²).
            let turn = SPIRAL * out;
            let (cosine, sine, per) = (1.0 - turn * turn, 2.0 * turn, 1.0 / ((1.0 + turn * turn) * out));
            let arm = [(x[i] * cosine - y[i] * sine) * per * 3.4, (x[i] * sine + y[i] * cosine) * per * 3.4, out * 2.2];
            let trough = TROUGH.at(noise_at(winds.troughs, arm).abs() + 0.06 * noises.patch[i]);
            ice[i] *= 1.0 - 0.6 * trough * (out * 4.0).min(1.0);
        }
        ice
    }
}

impl Paints {
    /// Dust and dark sand, and how dark it is, 0 to 1.
    #[inline(always)]
    fn soil(&self, site: &Site, i: usize, [climate, patch, thicket, tuft, streak]: [f32; 5]) -> (Rgb, f32) {
        const HIGH: Ramp = Ramp::new([2000.0, 9000.0]);
        const PALE: Ramp = Ramp::new([-0.1, 0.8]);
        const RUDDY: Ramp = Ramp::new([-0.1, 0.7]);
        // High ground is out of reach of sand, and covered by dust.
        let swept = 0.95 * climate + 0.6 * streak + 0.28 * patch + 0.06 * thicket + 0.04 * tuft - 0.8 * HIGH.at(site.height[i]);
        let dust = mixed(self.dust, self.strata, 0.75 * PALE.at(0.5 * patch - 0.8 * streak - 0.5 * climate + 0.3 * thicket));
        let dust = mixed(dust, self.rock, 0.5 * RUDDY.at(climate + 0.6 * streak - 0.3 * patch + 0.2 * thicket));
        let dark = self.dark.at(swept) * (0.8 + 0.25 * patch + 0.3 * streak).clamp(0.3, 1.0);
        (mixed(dust, self.sand, dark), dark)
    }
}
