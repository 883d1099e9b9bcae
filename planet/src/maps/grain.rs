//! Grain of the ground: tileable maps of slopes and brightness finer than any patch holds. One of bare ground and grass, from periodic
//! gradient noise (Perlin 1985); one of the crowns of trees, domes about scattered points (Worley 1996).
//!
//! Out: mip levels of [`GRAIN_SIDE`]² texels, in which both average out to nothing.

use super::mip;
use crate::globe::random::Random;

/// Texels along a side.
pub const GRAIN_SIDE: usize = 256;

/// Layer of the grain of bare ground and grass among the maps that are looked up.
pub const GROUND_LAYER: u32 = 0;
/// Layer of the crowns of trees.
pub const CROWN_LAYER: u32 = 1;

/// Noise cells along a side of the coarsest octave, and octaves.
const CELLS: usize = 8;
const OCTAVES: u32 = 4;

/// Share of each octave in height, of that before.
const GAIN: f32 = 0.55;

/// One mip level: slopes along both axes with a mean square of 1, and brightness with a mean square of 1, row by row.
pub type GrainLevel = Vec<[f32; 3]>;

/// Crowns along a side.
const CROWNS: usize = 32;

/// All mip levels of the grain of bare ground, down to one texel.
pub fn grain_map(seed: u64) -> Vec<GrainLevel> {
    let heights = fractal(seed);
    let tint = fractal(seed ^ 0x5eed);
    // Hollows are darker.
    let brightness: Vec<f32> = heights.iter().zip(&tint).map(|(height, tint)| 0.5 * tint + 0.5 * height).collect();
    levels(&heights, &brightness)
}

/// All mip levels of the crowns of a wood, down to one texel.
pub fn crown_map(seed: u64) -> Vec<GrainLevel> {
    let (mut heights, mut tints) = crowns(seed);
    let stand = fractal(seed ^ 0x57a4d);
    for ((height, tint), stand) in heights.iter_mut().zip(&mut tints).zip(&stand) {
        // Gaps are dark, and stands of trees differ.
        *tint = 0.35 * *tint + 1.3 * *height + 0.3 * stand;
        *height += 0.2 * stand;
    }
    levels(&heights, &tints)
}

/// Height over the gaps and tint of the crowns of trees: the highest dome at each texel.
fn crowns(seed: u64) -> (Vec<f32>, Vec<f32>) {
    let mut random = Random::new(seed);
    let mut draw = |low: f64, high: f64| random.range(low, high) as f32;
    // Position within its cell, radius in cells, tint.
    let trees: Vec<[f32; 4]> =
        (0..CROWNS * CROWNS).map(|_| [draw(0.0, 1.0), draw(0.0, 1.0), draw(0.5, 0.95), draw(-1.0, 1.0)]).collect();
    let texel = |k: usize| {
        let [x, y] = [k % GRAIN_SIDE, k / GRAIN_SIDE].map(|t| (t as f32 + 0.5) * CROWNS as f32 / GRAIN_SIDE as f32);
        let (column, row) = (x as usize, y as usize);
        let mut top = (0.0_f32, -1.0_f32);
        for (i, j) in (0..3).flat_map(|j| (0..3).map(move |i| (i, j))) {
            let [cell_x, cell_y] = [column + CROWNS + i - 1, row + CROWNS + j - 1];
            let [u, v, radius, tint] = trees[cell_y % CROWNS * CROWNS + cell_x % CROWNS];
            let (dx, dy) = (x + CROWNS as f32 - cell_x as f32 - u, y + CROWNS as f32 - cell_y as f32 - v);
            let height = radius * (1.0 - (dx * dx + dy * dy) / (radius * radius)).max(0.0).sqrt();
            if height > top.0 {
                top = (height, tint);
            }
        }
        top
    };
    (0..GRAIN_SIDE * GRAIN_SIDE).map(texel).unzip()
}

/// Mip levels of the slopes of heights, and of a brightness.
fn levels(heights: &[f32], brightness: &[f32]) -> Vec<GrainLevel> {
    let side = GRAIN_SIDE;
    let at = |x: usize, y: usize| heights[y % side * side + x % side];
    let texel = |k: usize| {
        let (x, y) = (k % side, k / side);
        let slope = [at(x + 1, y) - at(x + side - 1, y), at(x, y + 1) - at(x, y + side - 1)];
        [slope[0], slope[1], brightness[k]]
    };
    let mut level: GrainLevel = (0..side * side).map(texel).collect();
    normalise(&mut level, &[0, 1]);
    normalise(&mut level, &[2]);
    mip::levels(level, side)
}

/// Takes the mean from channels and scales them to a mean square of 1 together.
fn normalise(level: &mut GrainLevel, channels: &[usize]) {
    let count = level.len() as f32;
    for &channel in channels {
        let mean = level.iter().map(|texel| texel[channel]).sum::<f32>() / count;
        level.iter_mut().for_each(|texel| texel[channel] -= mean);
    }
    let square = |texel: &[f32; 3]| channels.iter().map(|&c| texel[c] * texel[c]).sum::<f32>();
    let scale = 1.0 / (level.iter().map(square).sum::<f32>() / count).sqrt().max(f32::MIN_POSITIVE);
    for texel in level {
        channels.iter().for_each(|&channel| texel[channel] *= scale);
    }
}

fn fractal(seed: u64) -> Vec<f32> {
    let mut heights = vec![0.0; GRAIN_SIDE * GRAIN_SIDE];
    let mut gain = 1.0;
    for octave in 0..OCTAVES {
        let cells = CELLS << octave;
        let mut random = Random::new(seed.wrapping_mul(31).wrapping_add(u64::from(octave)));
        let gradients: Vec<[f32; 2]> = (0..cells * cells)
            .map(|_| {
                let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
                [cos as f32, sin as f32]
            })
            .collect();
        for (k, height) in heights.iter_mut().enumerate() {
            *height += gain * noise(&gradients, cells, [k % GRAIN_SIDE, k / GRAIN_SIDE]);
        }
        gain *= GAIN;
    }
    heights
}

/// Gradient noise at a texel, periodic in the side.
fn noise(gradients: &[[f32; 2]], cells: usize, texel: [usize; 2]) -> f32 {
    let [x, y] = texel.map(|t| t as f32 * cells as f32 / GRAIN_SIDE as f32);
    let (column, row) = (x as usize, y as usize);
    let (u, v) = (x - column as f32, y - row as f32);
    let corner = |i: usize, j: usize| {
        let [gx, gy] = gradients[(row + j) % cells * cells + (column + i) % cells];
        gx * (u - i as f32) + gy * (v - j as f32)
    };
    let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (a, b) = (fade(u), fade(v));
    let (low, high) = ([corner(0, 0), corner(1, 0)], [corner(0, 1), corner(1, 1)]);
    let (low, high) = (low[0] + (low[1] - low[0]) * a, high[0] + (high[1] - high[0]) * a);
    low + (high - low) * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grain_has_mean_zero_and_unit_variance() {
        for levels in [grain_map(3), crown_map(3)] {
            assert_eq!((levels.len(), levels[8].len()), (9, 1));
            let mean = |of: &dyn Fn(&[f32; 3]) -> f32| levels[0].iter().map(of).sum::<f32>() / levels[0].len() as f32;
            assert!((mean(&|t| t[0] * t[0] + t[1] * t[1]) - 1.0).abs() < 1e-2 && (mean(&|t| t[2] * t[2]) - 1.0).abs() < 1e-2);
            assert!(levels[8][0].iter().all(|x| x.abs() < 1e-3), "{:?}", levels[8]);
            let edge = |x: usize| levels[0][x][2] - levels[0][(x + 1) % GRAIN_SIDE][2];
            assert!(edge(GRAIN_SIDE - 1).abs() < 3.0 * (0..GRAIN_SIDE - 1).map(|x| edge(x).abs()).fold(0.0, f32::max));
        }
    }

    #[test]
    fn crowns_continue_across_the_edge_of_the_map() {
        let (heights, _) = crowns(3);
        let step = |a: usize, b: usize| (heights[a] - heights[b]).abs();
        let across =
            |x: usize| (0..GRAIN_SIDE).map(|y| step(y * GRAIN_SIDE + x, y * GRAIN_SIDE + (x + 1) % GRAIN_SIDE)).sum::<f32>();
        let usual = (0..GRAIN_SIDE).map(across).sum::<f32>() / GRAIN_SIDE as f32;
        assert!(across(GRAIN_SIDE - 1) < 1.5 * usual, "{} and {usual}", across(GRAIN_SIDE - 1));
        let gaps = heights.iter().filter(|&&h| h < 0.1).count() as f32 / heights.len() as f32;
        assert!((0.01..0.3).contains(&gaps), "{gaps} of the wood is gaps");
    }
}
