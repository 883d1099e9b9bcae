//! Sums of noise octaves: fractional Brownian motion, billows, ridged multifractals (Musgrave 1994) and domain warps.
//! In: a chunk of points in metres. Out: one value for each point.

use super::noise::{mix, Lattice};
use super::points::{Lane, Points, LANES};
use crate::recipe::Octaves;

/// Ratio of successive wavelengths; not 2, so that lattice nodes of successive octaves never coincide.
const LACUNARITY: f64 = 1.97;

/// A run of octaves, ready to evaluate.
#[derive(Clone, Debug)]
pub(crate) struct Fractal {
    octaves: Vec<(Lattice, f32)>,
    /// Wavelength of each octave in metres.
    wavelengths_m: Vec<f32>,
    /// Sum of the amplitudes, the first being 1: the bound of the sum of octaves.
    pub(crate) total: f64,
}

impl Fractal {
    /// Octaves from `wavelength_m` down to `detail_m`, each `gain` times the one before.
    pub(crate) fn new(seed: u64, run: &Octaves) -> Self {
        let (mut octaves, mut wavelengths_m, mut total) = (Vec::new(), Vec::new(), 0.0);
        let (mut wavelength, mut amplitude) = (run.wavelength_m, 1.0);
        while wavelength >= run.detail_m {
            let turn = octaves.len() + (seed >> 32) as usize;
            octaves.push((Lattice::new(mix(seed ^ mix(octaves.len() as u64)), turn, wavelength), amplitude as f32));
            wavelengths_m.push(wavelength as f32);
            total += amplitude;
            wavelength /= LACUNARITY;
            amplitude *= run.gain;
        }
        Self { octaves, wavelengths_m, total }
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
    #[inline(always)]
    pub(crate) fn sum(&self, p: &Points, shape: impl Fn(f32) -> f32) -> Lane {
        let mut sum = [0.0; LANES];
        for (lattice, amplitude) in &self.octaves {
            lattice.noise(p, |i, noise| sum[i] += shape(noise) * amplitude);
        }
        sum
    }

    /// Fractional Brownian motion, within ± `total`.
    #[inline(always)]
    pub(crate) fn brownian(&self, p: &Points) -> Lane {
        self.sum(p, |noise| noise)
    }

    /// Fractional Brownian motion as far as samples `spacing` metres apart show it: octaves fade out before they are too fine.
    #[inline(always)]
    pub(crate) fn seen(&self, p: &Points, spacing: &Lane) -> Lane {
        let mut sum = [0.0; LANES];
        for ((lattice, amplitude), wavelength_m) in self.octaves.iter().zip(&self.wavelengths_m) {
            let mut share = [0.0; LANES];
            for i in 0..LANES {
                share[i] = (wavelength_m / spacing[i] - 1.5).clamp(0.0, 1.0) * amplitude;
            }
            if !any_above_zero(&share) {
                break;
            }
            lattice.noise(p, |i, noise| sum[i] += noise * share[i]);
        }
        sum
    }

    /// Ridged multifractal from 0 to 1: sharp crests, each octave damped where the ones before it are low, so that
    /// valleys stay smooth and ridges branch.
    #[inline(always)]
    pub(crate) fn ridged(&self, p: &Points) -> Lane {
        let (mut sum, mut weight) = ([0.0; LANES], [1.0; LANES]);
        for (lattice, amplitude) in &self.octaves {
            let share = amplitude / self.total as f32;
            lattice.noise(p, |i, noise| {
                let crest = 1.0 - (noise.abs() * 1.5).min(1.0);
                let signal = crest * crest * weight[i];
                sum[i] += signal * share;
                weight[i] = (0.22 + signal * 1.8).min(1.0);
            });
        }
        sum
    }
}

/// Pushes points about by noise.
#[derive(Clone, Debug)]
pub(crate) struct Warp {
    axes: [Fractal; 3],
    reach_m: f64,
    /// Radius of the sphere on which points stay, if they do.
    sphere_m: Option<f64>,
}

impl Warp {
    pub(crate) fn new(seed: u64, wavelength_m: f64, reach_m: f64, octaves: i32) -> Option<Self> {
        let axis = |i: u64| Fractal::few(mix(seed ^ mix(900 + i)), wavelength_m, octaves);
        (reach_m > 0.0).then(|| Self { axes: [axis(0), axis(1), axis(2)], reach_m, sphere_m: None })
    }

    /// The same warp, along a sphere: for what is worked out for points on it. `reach_m` must be well below its radius.
    pub(crate) fn along_sphere(self, radius_m: f64) -> Self {
        Self { sphere_m: Some(radius_m), ..self }
    }

    /// The points where a layer looks: pushed about, in `room`, if it has a warp.
    #[inline(always)]
    pub(crate) fn moved<'a>(warp: Option<&Warp>, p: &'a Points, room: &'a mut Option<Points>) -> &'a Points {
        match warp {
            Some(warp) => room.insert(warp.apply(p)),
            None => p,
        }
    }

    #[inline(always)]
    fn apply(&self, p: &Points) -> Points {
        let mut position = p.position;
        for (axis, coordinate) in self.axes.iter().zip(&mut position) {
            let push = axis.brownian(p);
            for i in 0..LANES {
                coordinate[i] += f64::from(push[i]) * self.reach_m;
            }
        }
        if let Some(radius) = self.sphere_m {
            for i in 0..LANES {
                let [x, y, z] = [position[0][i], position[1][i], position[2][i]];
                let scale = radius / (x * x + y * y + z * z).sqrt();
                (position[0][i], position[1][i], position[2][i]) = (x * scale, y * scale, z * scale);
            }
        }
        Points::at(position)
    }
}

/// A smooth rise from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ramp {
    from: f32,
    per_width: f32,
}

impl Ramp {
    /// 0 below `edges[0]`, 1 above `edges[1]`.
    #[inline(always)]
    pub(crate) const fn new(edges: [f64; 2]) -> Self {
        Self { from: edges[0] as f32, per_width: (1.0 / (edges[1] - edges[0])) as f32 }
    }

    #[inline(always)]
    pub(crate) fn at(self, v: f32) -> f32 {
        let t = ((v - self.from) * self.per_width).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// The ramp over every lane.
    #[inline(always)]
    pub(crate) fn lanes(self, values: &Lane) -> Lane {
        let mut out = *values;
        for v in &mut out {
            *v = self.at(*v);
        }
        out
    }
}

/// Whether any lane is above 0.
#[inline(always)]
pub(crate) fn any_above_zero(lane: &Lane) -> bool {
    lane.iter().fold(false, |any, &v| any | (v > 0.0))
}
