//! A picture at full size and at half of it, again and again (Williams 1983). In: sRGB-encoded pixels. Out: linear colours between pixels
//! and between levels, smooth in both.
//!
//! Means are taken of light. On a map of the whole planet each level is smoothed along parallels as far as its pixels are narrower there than
//! high, so that no level shows more near the poles than elsewhere.

use super::super::grid::spline_weights;
use super::srgb::Curve;
use rayon::prelude::*;
use terrane_heightfield::angles::sin_cos;

/// A colour in linear light.
pub(super) type Light = [f32; 3];

/// Share of a pixel that must be land for its colour to count wholly.
const LAND_SHARE: f32 = 0.5;

/// One level.
struct Level {
    size: [usize; 2],
    pixels: Vec<[u8; 3]>,
    /// How much of each pixel counts, of 255; none where all do.
    counts: Option<Vec<u8>>,
    /// Means of the first and of the last row.
    poles: [Light; 2],
}

/// All levels.
pub(in crate::terrain) struct Mips {
    curve: Curve,
    levels: Vec<Level>,
    /// Whether the last column's neighbour is the first, and all columns meet beyond the outermost rows.
    wraps: bool,
}

impl Mips {
    /// Levels of a picture. `counts` says how much of each pixel counts, of 255; what does not takes the colour of what does around it.
    pub(in crate::terrain) fn new(size: [usize; 2], pixels: Vec<[u8; 3]>, counts: Option<Vec<u8>>, wraps: bool) -> Mips {
        let curve = Curve::new();
        let mut levels = vec![Level { size, pixels, counts, poles: [[0.0; 3]; 2] }];
        while let Some(last) = levels.last().filter(|last| last.size.iter().min().is_some_and(|&side| side > 1)) {
            levels.push(last.halved(&curve));
        }
        for k in (1..levels.len()).rev() {
            let (finer, coarser) = levels.split_at_mut(k);
            if let (Some(finer), Some(coarser)) = (finer.last_mut(), coarser.first()) {
                finer.fill(coarser, &curve);
            }
        }
        for level in &mut levels {
            level.counts = None;
            if wraps {
                level.smooth_parallels(&curve);
            }
            level.poles = [0, level.size[1] - 1].map(|row| level.row_mean(row, &curve));
        }
        Mips { curve, levels, wraps }
    }

    /// Encodes a colour: from 0 to 255 a channel.
    #[inline(always)]
    pub(super) fn encoded(&self, light: Light) -> [f32; 3] {
        light.map(|light| self.curve.encoded(light))
    }

    /// Linear colour at a position in pixels of the picture, where samples stand `ratio` pixels apart.
    pub(super) fn at(&self, [column, row]: [f64; 2], ratio: f64) -> Light {
        let (mut level, mut ratio) = (0, ratio.max(1.0));
        while ratio >= 2.0 && level + 1 < self.levels.len() {
            (level, ratio) = (level + 1, ratio * 0.5);
        }
        let share = (ratio - 1.0).min(1.0) as f32;
        let fine = self.on_level(level, column, row);
        if share <= 0.0 || level + 1 == self.levels.len() {
            return fine;
        }
        mixed(fine, self.on_level(level + 1, column, row), share)
    }

    /// Smooth colour on one level: quadratic B-spline, which neither rings nor shows edges of pixels.
    fn on_level(&self, level: usize, column: f64, row: f64) -> Light {
        let (level, whole) = (&self.levels[level], self.levels[0].size);
        let place = |at: f64, k: usize| (at + 0.5) * (level.size[k] as f64 / whole[k] as f64) - 0.5;
        let (column, row) = (place(column, 0), place(row, 1));
        let colour = level.spline(column, row, self.wraps, &self.curve);
        if !self.wraps {
            return colour;
        }
        // Beyond the outermost rows' centres all longitudes meet: go over to the row's mean.
        let rise = |t: f64| {
            let t = (2.0 * t).clamp(0.0, 1.0);
            (t * t * (3.0 - 2.0 * t)) as f32
        };
        let colour = mixed(colour, level.poles[0], rise(-row));
        mixed(colour, level.poles[1], rise(row - (level.size[1] as f64 - 1.0)))
    }
}

#[inline(always)]
fn mixed(a: Light, b: Light, t: f32) -> Light {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

/// What a pixel of the next level takes along one axis: the first pixel, and the shares of up to three.
fn taken(at: usize, coarse: usize, fine: usize) -> (usize, [f32; 3]) {
    let step = fine as f64 / coarse as f64;
    let (from, to) = (at as f64 * step, (at + 1) as f64 * step);
    let first = (from.floor() as usize).min(fine - 1);
    let share = |k: usize| {
        let pixel = (first + k) as f64;
        if first + k < fine {
            ((to.min(pixel + 1.0) - from.max(pixel)).max(0.0) / step) as f32
        } else {
            0.0
        }
    };
    (first, [share(0), share(1), share(2)])
}

impl Level {
    fn light(&self, column: usize, row: usize, curve: &Curve) -> Light {
        self.pixels[row * self.size[0] + column].map(|channel| curve.light(channel))
    }

    fn spline(&self, column: f64, row: f64, wraps: bool, curve: &Curve) -> Light {
        let [columns, rows] = self.size.map(|side| side as i64);
        let ((c, across), (r, down)) = (spline_weights(column), spline_weights(row));
        let mut sum = [0.0; 3];
        for (j, wj) in down.iter().enumerate() {
            let row = (r + j as i64 - 1).clamp(0, rows - 1);
            for (i, wi) in across.iter().enumerate() {
                let column = c + i as i64 - 1;
                let column = if wraps { column.rem_euclid(columns) } else { column.clamp(0, columns - 1) };
                let light = self.light(column as usize, row as usize, curve);
                for k in 0..3 {
                    sum[k] += wi * wj * light[k];
                }
            }
        }
        sum
    }

    fn row_mean(&self, row: usize, curve: &Curve) -> Light {
        let mut sum = [0.0; 3];
        for column in 0..self.size[0] {
            let light = self.light(column, row, curve);
            sum = [0, 1, 2].map(|k| sum[k] + f64::from(light[k]));
        }
        sum.map(|sum| (sum / self.size[0] as f64) as f32)
    }

    /// The next level: means of light, of what counts.
    fn halved(&self, curve: &Curve) -> Level {
        let size = self.size.map(|side| side.div_ceil(2));
        let row = |row: usize| {
            let down = taken(row, size[1], self.size[1]);
            (0..size[0]).map(move |column| self.mean(taken(column, size[0], self.size[0]), down, curve)).collect::<Vec<_>>()
        };
        let (pixels, counts): (Vec<_>, Vec<_>) = (0..size[1]).into_par_iter().flat_map_iter(row).unzip();
        let counts = self.counts.is_some().then_some(counts);
        Level { size, pixels, counts, poles: [[0.0; 3]; 2] }
    }

    fn mean(&self, across: (usize, [f32; 3]), down: (usize, [f32; 3]), curve: &Curve) -> ([u8; 3], u8) {
        let (mut sum, mut plain, mut counted) = ([0.0; 3], [0.0; 3], 0.0);
        for (j, wj) in down.1.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            for (i, wi) in across.1.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                let (column, row) = (across.0 + i, down.0 + j);
                let light = self.light(column, row, curve);
                let counts = self.counts.as_ref().map_or(1.0, |c| f32::from(c[row * self.size[0] + column]) * (1.0 / 255.0));
                for k in 0..3 {
                    plain[k] += wi * wj * light[k];
                    sum[k] += wi * wj * counts * light[k];
                }
                counted += wi * wj * counts;
            }
        }
        let mean = if counted > 0.0 { sum.map(|s| s / counted) } else { plain };
        (mean.map(|light| curve.byte(light)), (counted * 255.0 + 0.5) as u8)
    }

    /// Gives pixels that do not count the colours of the coarser level.
    fn fill(&mut self, coarser: &Level, curve: &Curve) {
        let Some(counts) = &self.counts else { return };
        let [columns, rows] = self.size;
        self.pixels.par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
            let above = row * coarser.size[1] / rows;
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let own = f32::from(counts[row * columns + column]) * (1.0 / 255.0 / LAND_SHARE);
                if own < 1.0 {
                    let behind = coarser.light(column * coarser.size[0] / columns, above, curve);
                    let light = pixel.map(|channel| curve.light(channel));
                    *pixel = mixed(behind, light, own).map(|light| curve.byte(light));
                }
            }
        });
    }

    /// Smooths rows of a map of the whole planet along parallels, over as many pixels as are together as wide as one is high.
    fn smooth_parallels(&mut self, curve: &Curve) {
        let [columns, rows] = self.size;
        self.pixels.par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
            let latitude = 90.0 - 180.0 * (row as f64 + 0.5) / rows as f64;
            let width = (1.0 / sin_cos(latitude).1).min(columns as f64);
            if width > 1.05 {
                smooth_row(pixels, width, curve);
            }
        });
    }
}

/// The mean over `width` pixels about each of a row that closes in itself.
fn smooth_row(pixels: &mut [[u8; 3]], width: f64, curve: &Curve) {
    let columns = pixels.len() as i64;
    // Sums of all before each pixel, of three rounds.
    let mut sums = vec![[0.0_f64; 3]];
    for k in 0..3 * columns {
        let (last, light) = (sums[k as usize], pixels[(k % columns) as usize].map(|channel| f64::from(curve.light(channel))));
        sums.push([0, 1, 2].map(|c| last[c] + light[c]));
    }
    let until = |at: f64| {
        let whole = at.floor();
        let (low, high, share) = (sums[whole as usize], sums[whole as usize + 1], at - whole);
        [0, 1, 2].map(|c| low[c] + (high[c] - low[c]) * share)
    };
    for (column, pixel) in pixels.iter_mut().enumerate() {
        let middle = column as f64 + 0.5 + columns as f64;
        let (from, to) = (until(middle - 0.5 * width), until(middle + 0.5 * width));
        *pixel = [0, 1, 2].map(|c| curve.byte(((to[c] - from[c]) / width) as f32));
    }
}
