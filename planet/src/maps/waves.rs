//! Waves of the sea as tileable slope maps: what a pixel can resolve of a wind sea, and how much it cannot.
//!
//! Each [`Cascade`] covers a band of wavelengths with sines whose slopes have the variance of the saturation range of a wind sea (Phillips
//! 1985: the same in every octave), running mostly downwind. Total slope variance after Cox and Munk (1954). Every mip level also says what
//! variance it still resolves (Bruneton, Neyret and Holzschuch 2010): the rest is roughness, so that glitter widens with distance.

use super::mip::halved;
use crate::globe::random::Random;

/// Texels along a side of a cascade.
pub const WAVE_SIDE: usize = 256;

/// Metres after which everything that repeats repeats together.
pub const REPEAT_M: f64 = 1024.0;

/// Speed of the wind in metres a second.
const WIND: f64 = 7.0;

/// Slope variance of a natural logarithm of wavelengths: half of Phillips' constant.
const VARIANCE_A_LOG: f64 = 0.0041;

/// Sines in a cascade.
const SINES: usize = 96;

/// Radians by which waves stray from the wind, one deviation, long ones and short ones.
const STRAY: [f64; 2] = [0.45, 1.0];

/// A band of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    /// Copies of the map within [`REPEAT_M`].
    pub copies: u32,
    /// Longest and shortest wavelength in metres.
    pub wavelengths: [f64; 2],
}

/// Bands of a wind sea: none repeats with another.
pub const CASCADES: [Cascade; 3] = [
    Cascade { copies: 3, wavelengths: [46.0, 11.0] },
    Cascade { copies: 19, wavelengths: [11.0, 1.4] },
    Cascade { copies: 151, wavelengths: [1.4, 0.16] },
];

/// Variance of all slopes of a wind sea, upwind and crosswind together.
pub fn total_variance() -> f64 {
    0.003 + 0.00512 * WIND
}

/// One mip level of a cascade: slopes along both axes and the variance that they still hold, row by row.
pub type WaveLevel = Vec<[f32; 3]>;

/// All mip levels of a cascade, down to one texel.
pub fn wave_map(cascade: &Cascade, seed: u64) -> Vec<WaveLevel> {
    let mut slopes = sines(cascade, seed);
    let mut side = WAVE_SIDE;
    let mut levels = Vec::new();
    loop {
        let variance = slopes.iter().map(|[x, y]| x * x + y * y).sum::<f32>() / slopes.len() as f32;
        levels.push(slopes.iter().map(|&[x, y]| [x, y, variance]).collect());
        if side == 1 {
            return levels;
        }
        slopes = halved(&slopes, side);
        side /= 2;
    }
}

/// Slopes of the band's sines; every one fits the tile a whole number of times.
fn sines(cascade: &Cascade, seed: u64) -> Vec<[f32; 2]> {
    let mut random = Random::new(seed);
    let [longest, shortest] = cascade.wavelengths;
    let tile = REPEAT_M / f64::from(cascade.copies);
    // Half the square of a sine's amplitude is its variance.
    let amplitude = (2.0 * VARIANCE_A_LOG * (longest / shortest).ln() / SINES as f64).sqrt();
    let mut slopes = vec![[0.0f32; 2]; WAVE_SIDE * WAVE_SIDE];
    for _ in 0..SINES {
        let share = random.unit();
        let wavelength = longest * (shortest / longest).powf(share);
        let stray = STRAY[0] + (STRAY[1] - STRAY[0]) * share;
        // The sum of four uniform numbers is near enough to a normal one: its deviation is 2 / √3.
        let normal: f64 = (0..4).map(|_| random.range(-1.0, 1.0)).sum::<f64>() * 3f64.sqrt() / 2.0;
        let angle = 0.6 + stray * normal;
        let [x, y] = [angle.cos(), angle.sin()].map(|c| (c * tile / wavelength).round());
        let phase = random.range(0.0, std::f64::consts::TAU);
        let length = x.hypot(y).max(1.0);
        let along = [x, y].map(|c| (amplitude * c / length) as f32);
        add_sine(&mut slopes, [x, y], phase, along);
    }
    slopes
}

fn add_sine(slopes: &mut [[f32; 2]], [x, y]: [f64; 2], phase: f64, along: [f32; 2]) {
    let step = std::f64::consts::TAU / WAVE_SIDE as f64;
    for (row, slopes) in slopes.chunks_exact_mut(WAVE_SIDE).enumerate() {
        // Turned on from texel to texel: a sine for each would take a second.
        let (mut sin, mut cos) = (phase + step * y * row as f64).sin_cos();
        let (turn_sin, turn_cos) = (step * x).sin_cos();
        for slope in slopes {
            slope[0] += along[0] * cos as f32;
            slope[1] += along[1] * cos as f32;
            (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_hold_the_variance_of_their_band() {
        let mut resolved = 0.0;
        for (seed, cascade) in CASCADES.iter().enumerate() {
            let levels = wave_map(cascade, seed as u64);
            assert_eq!((levels.len(), levels[0].len(), levels[8].len()), (9, WAVE_SIDE * WAVE_SIDE, 1));
            let expected = VARIANCE_A_LOG * (cascade.wavelengths[0] / cascade.wavelengths[1]).ln();
            let found = f64::from(levels[0][0][2]);
            assert!((found / expected - 1.0).abs() < 0.1, "{found} where {expected} is expected");
            assert!(levels.windows(2).all(|pair| pair[1][0][2] <= pair[0][0][2]), "mip levels add waves");
            assert!(levels[8][0][2] < 1e-6);
            resolved += found;
        }
        assert!(resolved < 0.9 * total_variance(), "nothing is left for ripples that no map holds");
    }

    #[test]
    fn maps_tile() {
        let level = &wave_map(&CASCADES[0], 1)[0];
        let jump = |a: usize, b: usize| (level[a][0] - level[b][0]).abs();
        let inside = (1..WAVE_SIDE).map(|x| jump(x, x - 1)).fold(0.0, f32::max);
        assert!(jump(0, WAVE_SIDE - 1) <= 1.5 * inside);
    }
}
