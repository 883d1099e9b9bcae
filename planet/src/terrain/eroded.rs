//! Mountains as water leaves them: a few octaves of ridged noise, and on their slopes gullies that run downhill and branch. After the
//! erosion noise of Clay John (2018) and Skovbo Johansen (2023): waves across the slope so far, octave by octave, each of which
//! bends the slope that the next one sees. In: a chunk of points in metres. Out: metres above the valley floors.

use super::noise::{mix, Lattice};
use super::octaves::{Fractal, Ramp};
use super::points::{axes, Lane, Points, LANES};
use crate::recipe::Octaves;

/// Ratio of successive wavelengths.
const LACUNARITY: f64 = 1.97;

/// Octaves of the massifs that gullies cut into, and what each is of the one before.
const MASSIFS: usize = 3;
const MASSIF_GAIN: f32 = 0.6;
/// How much of each is ridged. The first is not: valleys that are its lower half join, pans between ridges would not.
const RIDGED: [f32; MASSIFS] = [0.0, 0.65, 0.6];
/// Half-width of crests, in noise.
const CREST: f32 = 0.06;
/// Massifs reach down to floors at about this value, softly.
const FLOOR: f32 = -0.38;
const FLOOR_SOFTNESS: f32 = 0.18;

/// Octaves of gullies, the wavelength of the first relative to the massifs', and its amplitude.
const GULLIES: usize = 5;
const FIRST_GULLY: f64 = 0.27;
const GULLY_DEPTH: f32 = 0.092;
/// Slope at which gullies are as deep and as dense as half of what they can be.
const GULLY_SLOPE: f32 = 0.15;
/// Crests in one cell on steep ground.
const CRESTS: f32 = 1.2;
/// Crags, relative to the gullies that would come next.
const CRAGS: f32 = 1.0;

/// Massifs, gullies, crags.
#[derive(Clone, Debug)]
pub(crate) struct Eroded {
    massifs: Vec<(Lattice, f32)>,
    /// Each with its wavelength, and its amplitude.
    gullies: Vec<(Lattice, f32, f32)>,
    crags: Fractal,
    crag_share: f32,
    /// How high it can be where massifs are 1 high.
    highest: f32,
}

impl Eroded {
    pub(crate) fn new(seed: u64, run: &Octaves) -> Self {
        let turn = (seed >> 32) as usize;
        let lattice = |k: usize, wavelength_m: f64| Lattice::new(mix(seed ^ mix(k as u64)), turn + k, wavelength_m);
        let (mut massifs, mut gullies) = (Vec::new(), Vec::new());
        let mut wavelength_m = run.wavelength_m;
        for k in 0..MASSIFS {
            massifs.push((lattice(k, wavelength_m), (1.0 / wavelength_m) as f32));
            wavelength_m /= LACUNARITY;
        }
        let (mut wavelength_m, mut share) = (run.wavelength_m * FIRST_GULLY, GULLY_DEPTH);
        for k in 0..GULLIES {
            if wavelength_m < run.detail_m {
                break;
            }
            gullies.push((lattice(MASSIFS + k, wavelength_m), wavelength_m as f32, share));
            wavelength_m /= LACUNARITY;
            share *= run.gain as f32;
        }
        let crags = Fractal::new(mix(seed ^ 77), &Octaves { wavelength_m, ..run.clone() });
        let crag_share = CRAGS * share;
        let gullies_share = gullies.iter().fold(0.0, |sum, gully| sum + gully.2);
        Self { massifs, gullies, crags, crag_share, highest: highest_massif() + gullies_share + crag_share }
    }

    /// Metres at each point where massifs are `scale` metres high, never more than `scale` times [`Eroded::highest`].
    #[inline(always)]
    pub(crate) fn metres(&self, p: &Points, scale: &Lane) -> Lane {
        const SLOPES: Ramp = Ramp::new([0.0, 0.5]);
        let mut up = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let [x, y, z] = axes(|k| p.position[k][i] as f32);
            let per_length = 1.0 / (x * x + y * y + z * z).sqrt();
            (up[0][i], up[1][i], up[2][i]) = (x * per_length, y * per_length, z * per_length);
        }
        let (mut height, mut slope) = self.massifs(p);
        let mut cut = [0.0; LANES];
        for i in 0..LANES {
            let above = height[i] - FLOOR;
            let soft = (above * above + FLOOR_SOFTNESS * FLOOR_SOFTNESS).sqrt();
            let risen = 0.5 * (above + soft);
            let steep = scale[i] * 0.5 * (1.0 + above / soft);
            cut[i] = scale[i] * SLOPES.at(risen);
            height[i] = scale[i] * risen;
            for k in 0..3 {
                slope[k][i] *= steep;
            }
        }
        for gully in &self.gullies {
            cut_gullies(p, gully, (&up, &mut slope), &cut, &mut height);
        }
        let crags = self.crags.ridged(p);
        for i in 0..LANES {
            let across = crossed(axes(|k| up[k][i]), axes(|k| slope[k][i]));
            height[i] += self.crag_share * cut[i] * (0.15 + 0.85 * steepness(across).0) * crags[i];
        }
        height
    }

    /// How high it can be where massifs are 1 high.
    pub(crate) fn highest(&self) -> f32 {
        self.highest
    }

    /// Height of the massifs, 1 being high, and how much that grows a metre along each axis.
    #[inline(always)]
    fn massifs(&self, p: &Points) -> (Lane, [Lane; 3]) {
        let (mut height, mut slope) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let mut amplitude = 1.0;
        for (k, (lattice, per_metre)) in self.massifs.iter().enumerate() {
            let (ridge, share) = (RIDGED[k], amplitude * per_metre);
            lattice.noise_and_slope(p, |i, noise, own| {
                let fold = (noise * noise + CREST * CREST).sqrt();
                height[i] += amplitude * ((1.0 - ridge) * noise + ridge * (0.4 - 1.6 * fold));
                let bend = share * (1.0 - ridge - ridge * 1.6 * noise / fold);
                for axis in 0..3 {
                    slope[axis][i] += bend * own[axis];
                }
            });
            amplitude *= MASSIF_GAIN;
        }
        (height, slope)
    }
}

/// No massif is higher over the valley floors.
fn highest_massif() -> f32 {
    let (mut height, mut amplitude) = (0.0, 1.0);
    for ridge in RIDGED {
        // At the end of the noise's range, or near a crest.
        height += amplitude * (1.0 - 2.2 * ridge).max(0.4 * ridge + (1.0 - ridge) * CREST);
        amplitude *= MASSIF_GAIN;
    }
    let above = height - FLOOR;
    0.5 * (above + (above * above + FLOOR_SOFTNESS * FLOOR_SOFTNESS).sqrt())
}

/// Adds an octave of gullies, and what it changes of the slope. Waves stand across the slope, so that their hollows run down it.
#[inline(always)]
fn cut_gullies(
    p: &Points,
    (lattice, wavelength_m, share): &(Lattice, f32, f32),
    (up, slope): (&[Lane; 3], &mut [Lane; 3]),
    cut: &Lane,
    height: &mut Lane,
) {
    let (mut waves, mut depth) = ([[0.0; LANES]; 3], [0.0; LANES]);
    for i in 0..LANES {
        let across = crossed(axes(|k| up[k][i]), axes(|k| slope[k][i]));
        let (steep, per_slope) = steepness(across);
        depth[i] = share * cut[i] * steep;
        for k in 0..3 {
            waves[k][i] = across[k] * per_slope * CRESTS;
        }
    }
    let per_cell = std::f32::consts::TAU / wavelength_m;
    lattice.waves(p, &waves, |i, cosine, sine| {
        height[i] += depth[i] * cosine;
        for k in 0..3 {
            slope[k][i] -= depth[i] * sine * per_cell * waves[k][i];
        }
    });
}

/// How steep a slope is, 0 to 1, from the vector across it; and one over a length, by which that vector becomes one of at most 1.
#[inline(always)]
fn steepness(across: [f32; 3]) -> (f32, f32) {
    let square = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
    let length = (1.0 + square * (1.0 / (GULLY_SLOPE * GULLY_SLOPE))).sqrt();
    (1.0 - 1.0 / length, 1.0 / (GULLY_SLOPE * length))
}

#[inline(always)]
fn crossed(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::noise::unit;

    #[test]
    fn mountains_fill_their_bounds_and_stay_within() {
        let eroded = Eroded::new(5, &Octaves { wavelength_m: 15e3, detail_m: 2.0, gain: 0.8 });
        let (mut lowest, mut highest) = (f32::MAX, 0.0_f32);
        for n in 0..200_u64 {
            let lanes = |axis: u64| std::array::from_fn(|i| (unit(mix((n * 1000 + i as u64) ^ (axis << 40))) - 0.5) * 9e6);
            let metres = eroded.metres(&Points::at([lanes(1), lanes(2), lanes(3)]), &[1000.0; LANES]);
            lowest = metres.iter().fold(lowest, |low, &h| low.min(h));
            highest = metres.iter().fold(highest, |high, &h| high.max(h));
        }
        assert!(highest <= 1000.0 * eroded.highest() && highest > 450.0 * eroded.highest(), "{highest} m");
        assert!((0.0..100.0).contains(&lowest), "{lowest} m");
    }
}
