//! Colours of a dry, dusty world: bright dust, regions of dark sand with streaky edges, dunes, layered rock, polar ice. In: sites and noises of
//! a chunk. Out: a colour for each point.

use super::albedo::{mixed, put, rgb, ColourLanes, Noises, Rgb, Site};
use super::noise::{mix, noise_at};
use super::octaves::{Fractal, Ramp, Warp};
use super::points::{Lane, Points, LANES};
use super::Terrain;
use crate::recipe::{Desert, Octaves};
use terrane_heightfield::angles::sin_cos;

/// How much longer than wide the streaks at the edges of dark sand are: winds blow along parallels.
const STREAK: f64 = 2.5;

/// What desert colours need besides the palette.
pub(super) struct Winds {
    /// Regions of dark sand.
    regions: Fractal,
    /// Pulls them into wedges and tongues.
    warp: Option<Warp>,
    /// Frays their edges.
    streaks: Fractal,
    /// One over the sine of the polar distance of the ice's edge.
    per_edge: f64,
}

impl Winds {
    pub(super) fn new(seed: u64, palette: &Desert) -> Self {
        let edge = sin_cos(palette.ice_deg).1;
        Self {
            regions: Fractal::new(mix(seed ^ 23), &Octaves { wavelength_m: palette.climate_m, detail_m: 12e3, gain: 0.55 }),
            warp: Warp::new(mix(seed ^ 24), palette.climate_m * 0.5, palette.climate_m * 0.22, 2),
            streaks: Fractal::few(mix(seed ^ 21), palette.climate_m * 0.012, 4),
            per_edge: 1.0 / edge.max(1e-3),
        }
    }

    /// Noise drawn out along parallels.
    #[inline(always)]
    fn streaks(&self, p: &Points) -> Lane {
        let mut position = p.position;
        for z in &mut position[2] {
            *z *= STREAK;
        }
        self.streaks.brownian(&Points::at(position))
    }

    /// How much dark sand the winds leave where, about -1 to 1: in the belt from the southern middle latitudes to the equator, less on
    /// what is high, and in basins and on the lowest plains dust has settled.
    #[inline(always)]
    fn sand(&self, p: &Points, base: &Lane, per_radius: f64) -> Lane {
        const HIGH: Ramp = Ramp::new([1800.0, 4200.0]);
        const DEEP: Ramp = Ramp::new([-4300.0, -5300.0]);
        let mut room = None;
        let mut sand = self.regions.brownian(Warp::moved(self.warp.as_ref(), p, &mut room));
        for i in 0..LANES {
            let off = (p.position[2][i] * per_radius) as f32 + 0.22;
            let belt = 0.4 - 1.7 * off * off;
            sand[i] += 0.4 * belt - 1.1 * HIGH.at(base[i]) - 0.5 * DEEP.at(base[i]);
        }
        sand
    }
}

/// The ground's share of things besides dust.
struct Shares {
    sand: Lane,
    streaks: Lane,
    dunes: Lane,
    ice: Lane,
    /// Walls of troughs in the ice: bare layers of ice and dust.
    layered: Lane,
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
        let base = self.compose(p, None);
        let [ice, layered] = self.ice(winds, p, noises);
        let mut sand = winds.sand(p, &base, 1.0 / self.radius);
        for floor in self.rifts().filter_map(|rift| rift.floor(p)) {
            for i in 0..LANES {
                // Winds drop sand where they are sheltered.
                sand[i] += 0.36 * floor[i];
            }
        }
        let shares = Shares { sand, streaks: winds.streaks(p), dunes: self.dune_cover(p, &base), ice, layered };
        let middle = 0.75 - 1.5 * palette.sand_cover;
        let paints = Paints {
            dust: rgb(palette.dust),
            sand: rgb(palette.sand),
            dune: rgb(palette.dune),
            rock: rgb(palette.rock),
            strata: rgb(palette.strata),
            ice: rgb(palette.ice),
            rocky: Ramp::new(palette.rock_slope),
            dark: Ramp::new([middle - 0.14, middle + 0.14]),
        };
        for i in 0..LANES {
            let own = [noises.climate[i], noises.patch[i], noises.thicket[i], noises.tuft[i]];
            let (soil, dark) = paints.soil(&shares, i, own);
            let soil = mixed(soil, paints.dune, (0.3 + 0.6 * dark) * shares.dunes[i]);
            let steep = site.slope[i] * (1.0 + 0.2 * own[2] + 0.2 * own[3]);
            let bare = paints.rocky.at(steep);
            let ground = mixed(soil, mixed(paints.rock, paints.strata, noises.strata[i]), bare);
            let light = 1.0 + 0.04 * own[0] + 0.045 * own[1] + 0.05 * own[2] + 0.09 * own[3];
            put(out, i, mixed(ground, paints.frozen(&shares, i, site.height[i], own), shares.ice[i] * (1.0 - 0.5 * bare)), light);
        }
    }

    #[inline(always)]
    fn dune_cover(&self, p: &Points, base: &Lane) -> Lane {
        let mut cover = [0.0; LANES];
        for mask in self.dunes().filter(|dunes| dunes.coloured()).filter_map(|dunes| dunes.mask(p, base)) {
            for i in 0..LANES {
                cover[i] = mask[i].max(cover[i]);
            }
        }
        cover
    }

    /// How much of the ground is ice, and how much of that a trough's wall: frost with ragged edges past a latitude, and the caps.
    #[inline(always)]
    fn ice(&self, winds: &Winds, p: &Points, noises: &Noises) -> [Lane; 2] {
        const EDGE: Ramp = Ramp::new([-0.035, 0.035]);
        let per_axis = winds.per_edge / self.radius;
        let mut ice = [0.0; LANES];
        for i in 0..LANES {
            let (x, y) = ((p.position[0][i] * per_axis) as f32, (p.position[1][i] * per_axis) as f32);
            let ragged = 0.25 * noises.climate[i] + 0.16 * noises.patch[i] + 0.008 * noises.thicket[i];
            ice[i] = EDGE.at(1.0 - (x * x + y * y).sqrt() + ragged);
        }
        // Frost is patchy about a cap, whether the cap comes near this chunk or not.
        if self.caps().next().is_some() {
            for i in 0..LANES {
                ice[i] *= (0.6 + 0.8 * noises.patch[i] + 0.25 * noises.thicket[i]).clamp(0.0, 1.0);
            }
        }
        let mut layered = [0.0; LANES];
        for [cap, walls] in self.caps().filter_map(|caps| caps.cover(p)) {
            for i in 0..LANES {
                ice[i] = ice[i].max(cap[i]);
                layered[i] = walls[i].max(layered[i]);
            }
        }
        [ice, layered]
    }
}

impl Paints {
    /// Dust and dark sand, and how dark it is, 0 to 1.
    #[inline(always)]
    fn soil(&self, shares: &Shares, i: usize, [climate, patch, thicket, tuft]: [f32; 4]) -> (Rgb, f32) {
        const PALE: Ramp = Ramp::new([-0.1, 0.8]);
        const RUDDY: Ramp = Ramp::new([-0.1, 0.7]);
        let streak = shares.streaks[i];
        let swept = shares.sand[i] + 0.09 * streak + 0.1 * patch + 0.04 * thicket + 0.03 * tuft;
        let dust = mixed(self.dust, self.strata, 0.75 * PALE.at(0.5 * patch - 0.3 * streak - 0.7 * climate + 0.3 * thicket));
        let dust = mixed(dust, self.rock, 0.5 * RUDDY.at(climate + 0.2 * streak - 0.3 * patch + 0.2 * thicket));
        let dark = self.dark.at(swept) * (0.85 + 0.12 * climate + 0.16 * patch + 0.1 * streak).clamp(0.25, 1.0);
        (mixed(dust, self.sand, dark), dark)
    }

    /// Ice, or on a trough's wall its layers.
    #[inline(always)]
    fn frozen(&self, shares: &Shares, i: usize, height: f32, [_, patch, thicket, tuft]: [f32; 4]) -> Rgb {
        const LAYERS_M: f32 = 1.0 / 70.0;
        let level = height * LAYERS_M + 0.8 * patch;
        let bed = 0.5 + noise_at(0x1a7e, [level, 0.31 * level, 0.2 * patch]) + 0.2 * thicket;
        let beds = mixed(mixed(self.dust, self.rock, 0.6), self.strata, bed.clamp(0.0, 1.0));
        mixed(self.ice, beds, shares.layered[i] * (0.42 + 0.15 * tuft))
    }
}
