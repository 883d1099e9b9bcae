//! Sums of noise octaves: fractional Brownian motion, billows, ridged multifractals (Musgrave 1994) and domain warps.
//! In: a chunk of points in metres. Out: one value for each point.

use super::noise::{mix, noise_at, Lane, Lattice, Points, LANES};
use crate::recipe::Octaves;

/// Ratio of successive wavelengths; not 2, so that lattice nodes of successive octaves never coincide.
const LACUNARITY: f64 = 1.97;

/// A run of octaves, ready to evaluate.
#[derive(Clone, Debug)]
pub(crate) struct Fractal {
    octaves: Vec<(Lattice, f64)>,
    /// Sum of the amplitudes, the first being 1: the bound of the sum of octaves.
    pub(crate) total: f64,
}

impl Fractal {
    /// Octaves from `wavelength_m` down to `detail_m`, each `gain` times the one before.
    pub(crate) fn new(seed: u64, run: &Octaves) -> Self {
        let (mut octaves, mut total) = (Vec::new(), 0.0);
        let (mut wavelength, mut amplitude) = (run.wavelength_m, 1.0);
        while wavelength >= run.detail_m {
            octaves.push((Lattice::new(mix(seed ^ mix(octaves.len() as u64)), wavelength), amplitude));
            total += amplitude;
            wavelength /= LACUNARITY;
            amplitude *= run.gain;
        }
        Self { octaves, total }
    }

    /// A few octaves from one wavelength, at half the amplitude each.
    pub(crate) fn few(seed: u64, wavelength_m: f64, count: i32) -> Self {
        let mut detail_m = wavelength_m * 0.99;
        for _ in 1..count {
            detail_m /= LACUNARITY;
        }
        Self::new(seed, &Octaves { wavelength_m, detail_m, gain: 0.5 })
    }

    /// Sum of `shape(noise) * amplitude`.
    pub(crate) fn sum(&self, p: &Points, out: &mut Lane, shape: impl Fn(f64) -> f64) {
        let mut octave = [0.0; LANES];
        out[..p.count].fill(0.0);
        for (lattice, amplitude) in &self.octaves {
            noise_at(lattice, p, &mut octave);
            for (sum, &n) in out[..p.count].iter_mut().zip(&octave) {
                *sum += shape(n) * amplitude;
            }
        }
    }

    /// Fractional Brownian motion, within ± `total`.
    pub(crate) fn brownian(&self, p: &Points, out: &mut Lane) {
        self.sum(p, out, |n| n);
    }

    /// Ridged multifractal from 0 to 1: sharp crests, each octave damped where the ones before it are low, so that
    /// valleys stay smooth and ridges branch.
    pub(crate) fn ridged(&self, p: &Points, out: &mut Lane) {
        let (mut octave, mut weight) = ([0.0; LANES], [1.0; LANES]);
        out[..p.count].fill(0.0);
        for (lattice, amplitude) in &self.octaves {
            noise_at(lattice, p, &mut octave);
            let share = amplitude / self.total;
            for i in 0..p.count.min(LANES) {
                let crest = 1.0 - (octave[i].abs() * 1.5).min(1.0);
                let signal = crest * crest * weight[i];
                out[i] += signal * share;
                weight[i] = (0.22 + signal * 1.8).min(1.0);
            }
        }
    }
}

/// Pushes points about by noise.
#[derive(Clone, Debug)]
pub(crate) struct Warp {
    axes: [Fractal; 3],
    reach_m: f64,
}

impl Warp {
    pub(crate) fn new(seed: u64, wavelength_m: f64, reach_m: f64, octaves: i32) -> Option<Self> {
        let axis = |i: u64| Fractal::few(mix(seed ^ mix(900 + i)), wavelength_m, octaves);
        (reach_m > 0.0).then(|| Self { axes: [axis(0), axis(1), axis(2)], reach_m })
    }

    pub(crate) fn apply(&self, p: &Points) -> Points {
        let mut moved = p.clone();
        let mut push = [0.0; LANES];
        for (axis, target) in self.axes.iter().zip([&mut moved.x, &mut moved.y, &mut moved.z]) {
            axis.brownian(p, &mut push);
            for (t, &v) in target[..p.count].iter_mut().zip(&push) {
                *t += v * self.reach_m;
            }
        }
        moved
    }
}

/// 0 below `edges[0]`, 1 above `edges[1]`, smooth in between.
#[inline(always)]
pub(crate) fn smoothstep(edges: [f64; 2], v: f64) -> f64 {
    let t = ((v - edges[0]) / (edges[1] - edges[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
