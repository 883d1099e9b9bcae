//! The normal map of a heightfield: the whole of it, north up, its corners on the corner samples.
//!
//! A texel holds the mean slope of what it covers, which is the slope of the heights filtered to its size; between samples slopes are
//! interpolated linearly.

use super::super::normals::slopes_at;
use super::{encode_normal, Bitmap};
use glam::DVec3;
use rayon::prelude::*;
use terrane_heightfield::Heightfield;

/// Fewest texels of the shorter side.
const SHORTEST: u32 = 4;

/// The map with so many texels along its longer side; the shorter one has the next power of two. `scale` as in
/// [`super::super::Model::of_heightfield`].
pub(crate) fn normal_map(field: &Heightfield, scale: DVec3, side: u32) -> Bitmap {
    let last = [field.columns() - 1, field.rows() - 1].map(|last| last as f64);
    let slopes: Vec<[f64; 2]> = (0..field.rows())
        .into_par_iter()
        .flat_map_iter(|row| (0..field.columns()).map(move |column| slopes_at(field, [column, row], scale)))
        .collect();
    let at = |column: usize, row: usize| slopes[row * field.columns() + column];
    let between = |x: f64, y: f64| {
        let [column, row] = [(x as usize).min(field.columns() - 2), (y as usize).min(field.rows() - 2)];
        let [right, down] = [x - column as f64, y - row as f64];
        let mix = |a: [f64; 2], b: [f64; 2], share: f64| [0, 1].map(|k| a[k] + share * (b[k] - a[k]));
        let line = |row: usize| mix(at(column, row), at(column + 1, row), right);
        mix(line(row), line(row + 1), down)
    };
    let size = size(last, side);
    let step = [0, 1].map(|k| last[k] / f64::from(size[k]));
    let taps = step.map(|samples| samples.ceil().max(1.0) as usize);
    let texel = |column: u32, row: u32| {
        let place = |k: usize, texel: u32, tap: usize| (f64::from(texel) + (tap as f64 + 0.5) / taps[k] as f64) * step[k];
        let all = (0..taps[1]).flat_map(|down| (0..taps[0]).map(move |right| [right, down]));
        let sum = all.fold([0.0; 2], |sum, [right, down]| {
            let slope = between(place(0, column, right), place(1, row, down));
            [sum[0] + slope[0], sum[1] + slope[1]]
        });
        encode_normal(sum.map(|sum| sum / (taps[0] * taps[1]) as f64))
    };
    let texels = (0..size[1]).into_par_iter().flat_map_iter(|row| (0..size[0]).map(move |column| texel(column, row)));
    Bitmap { size, texels: texels.collect() }
}

/// Texels of a map over a rectangle of samples.
fn size([across, down]: [f64; 2], side: u32) -> [u32; 2] {
    let shorter = |share: f64| ((share * f64::from(side)).ceil() as u32).next_power_of_two().clamp(SHORTEST, side);
    if across >= down {
        [side, shorter(down / across)]
    } else {
        [shorter(across / down), side]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_have_their_signs_and_texels_their_means() {
        // 2 m up a column of 4 m: the normal leans west, red below the middle; north is up, and the southern half rises to the south.
        let heights = (0..9 * 9).map(|k| (k % 9) as f32 * 2.0 + ((k / 9) as f32 - 4.0).max(0.0) * 3.0).collect();
        let field = Heightfield::new(9, 9, heights).unwrap();
        let map = normal_map(&field, DVec3::new(4.0, 3.0, 1.0), 64);
        assert_eq!(map.size, [64, 64]);
        let at = |column: usize, row: usize| map.texels[row * 64 + column];
        assert_eq!(at(10, 5), encode_normal([0.5, 0.0]));
        assert_eq!(at(10, 60), encode_normal([0.5, -1.0]));
        assert!(at(10, 60)[1] > 128 && at(10, 5)[0] < 128);
        // Coarser than the samples: waves of two samples are level in the mean.
        let waves = Heightfield::new(257, 129, (0..257 * 129).map(|k| ((k % 257) % 4) as f32).collect()).unwrap();
        let map = normal_map(&waves, DVec3::ONE, 64);
        assert_eq!(map.size, [64, 32]);
        assert!(map.texels.iter().all(|t| t[0].abs_diff(128) < 32 && t[1] == 128), "{:?}", &map.texels[..4]);
    }
}
