//! From the radiance of a tile to the pixels of a picture: tone, filter, encoding.
//!
//! The samples of a pixel are averaged as the light of a display, after the tone curve: averaged before it, one sample of the sun's
//! glitter would outshine all others and its pixel's edges would be as jagged as without.

use crate::headless::Edge;
use glam::{Vec3, Vec4};
use half::f16;
use rayon::prelude::*;
use terrane_planet::draw::layout::Mode;
use terrane_planet::draw::tone::Curve;
use terrane_planet::draw::view::Window;
use terrane_planet::reference::tonemap::{decode_srgb, display, dither, encode_srgb};

/// The pixels of a picture: red, green, blue and alpha of each, row by row.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Encoded as sRGB; colours are not multiplied by alpha.
    Eight(Vec<u8>),
    /// The same with 16 bits, without dither.
    Sixteen(Vec<u16>),
    /// Radiance in linear light; colours are multiplied by alpha.
    Radiance(Vec<f16>),
}

/// What turns a tile into pixels.
pub(super) struct Developer<'a> {
    pub(super) mode: Mode,
    pub(super) exposure: f32,
    pub(super) curve: Curve,
    pub(super) ssaa: u32,
    /// Whether what lies behind the picture shows through it.
    pub(super) transparent: bool,
    /// Width and height of the picture.
    pub(super) picture: [u32; 2],
    /// The window that was drawn.
    pub(super) drawn: &'a Window,
    /// Which of its pixels show two surfaces; empty where none are mixed.
    pub(super) edges: Vec<Option<Edge>>,
}

impl Developer<'_> {
    /// Fills the pixels of a window from the samples of what was drawn, [`Developer::ssaa`] in each direction a pixel.
    pub(super) fn develop(&self, samples: &[f32], window: &Window, pixels: &mut Pixels) {
        match pixels {
            Pixels::Eight(all) => self.fill(all, window, |x, y, out| {
                let noise = if self.mode.is_plain() { 0.0 } else { dither(x, y) };
                let [r, g, b, alpha] = self.mixed(samples, [x, y]).to_array();
                let codes = [r, g, b].map(|c| c * 255.0 + noise);
                out.copy_from_slice(&[codes[0], codes[1], codes[2], alpha * 255.0].map(|c| c.round() as u8));
            }),
            Pixels::Sixteen(all) => self.fill(all, window, |x, y, out| {
                let shown = self.mixed(samples, [x, y]);
                out.copy_from_slice(&shown.to_array().map(|c| (c * 65535.0).round() as u16));
            }),
            Pixels::Radiance(all) => self.fill(all, window, |x, y, out| {
                let light = self.mean(samples, [x, y], |sample| sample);
                out.copy_from_slice(&light.to_array().map(f16::from_f32));
            }),
        }
    }

    fn fill<T: Send>(&self, all: &mut [T], window: &Window, pixel: impl Fn(u32, u32, &mut [T]) + Sync) {
        let [left, top] = window.origin;
        let [right, bottom] = [0, 1].map(|k| (window.origin[k] + window.size[k]).min(self.picture[k]));
        let row_length = 4 * self.picture[0] as usize;
        all.par_chunks_exact_mut(row_length).enumerate().skip(top as usize).take((bottom - top) as usize).for_each(|(y, row)| {
            for x in left..right {
                pixel(x, y as u32, &mut row[4 * x as usize..][..4]);
            }
        });
    }

    /// The encoded colour of a pixel, not multiplied by its alpha; on edges mixed with its neighbour's as `tonemap.frag` does.
    fn mixed(&self, samples: &[f32], at: [u32; 2]) -> Vec4 {
        let own = self.shown(samples, at);
        let [x, y] = [0, 1].map(|k| at[k] - self.drawn.origin[k]);
        let Some(Some(edge)) = self.edges.get((y * self.drawn.size[0] + x) as usize) else { return own };
        let beside = [0, 1].map(|k| {
            let last = self.drawn.origin[k] + self.drawn.size[k] - 1;
            at[k].saturating_add_signed(edge.neighbour[k]).clamp(self.drawn.origin[k], last)
        });
        let other = self.shown(samples, beside);
        let covered = |color: Vec4| (color.truncate() * color.w).extend(color.w);
        let sum = covered(own).lerp(covered(other), edge.share);
        if sum.w > 0.0 {
            (sum.truncate() / sum.w).extend(sum.w)
        } else {
            Vec4::ZERO
        }
    }

    /// The encoded colour of a pixel, not multiplied by its alpha.
    fn shown(&self, samples: &[f32], at: [u32; 2]) -> Vec4 {
        let tone = |sample: Vec4| display(self.mode, &self.curve, self.exposure, sample.truncate());
        if self.ssaa == 1 && !self.transparent {
            return tone(self.sample(samples, at, [0, 0])).extend(1.0);
        }
        let light = self.mean(samples, at, |sample| {
            let shown = tone(sample);
            // Light is never more than it covers: it is added to nothing.
            let cover = if sample.w > 0.0 { sample.w.max(shown.max_element()) } else { 0.0 };
            decode_srgb(if cover > 0.0 { shown } else { Vec3::ZERO }).extend(cover)
        });
        let shown = encode_srgb(light.truncate());
        let cover = light.w.max(shown.max_element()).min(1.0);
        if cover <= 0.0 {
            return Vec4::ZERO;
        }
        (shown / cover).min(Vec3::ONE).extend(cover)
    }

    fn mean(&self, samples: &[f32], at: [u32; 2], value: impl Fn(Vec4) -> Vec4) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for j in 0..self.ssaa {
            for i in 0..self.ssaa {
                sum += value(self.sample(samples, at, [i, j]));
            }
        }
        sum / (self.ssaa * self.ssaa) as f32
    }

    /// One sample of a pixel; opaque unless the picture is transparent, and nothing at all where that is empty.
    fn sample(&self, samples: &[f32], at: [u32; 2], [i, j]: [u32; 2]) -> Vec4 {
        let [x, y] = [(at[0] - self.drawn.origin[0]) * self.ssaa + i, (at[1] - self.drawn.origin[1]) * self.ssaa + j];
        let first = 4 * (y as usize * (self.drawn.size[0] * self.ssaa) as usize + x as usize);
        let sample = Vec4::from_slice(&samples[first..first + 4]);
        match sample.w {
            _ if !self.transparent => sample.truncate().extend(1.0),
            cover if cover <= 0.0 => Vec4::ZERO,
            _ => sample,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::draw::layout::Tone;

    const PIXEL: Window = Window { origin: [0; 2], size: [1; 2] };

    fn developer(ssaa: u32, transparent: bool) -> Developer<'static> {
        Developer {
            mode: Mode::Depth,
            exposure: 1.0,
            curve: Curve::new(Tone::Neutral, 0.85),
            ssaa,
            transparent,
            picture: [1, 1],
            drawn: &PIXEL,
            edges: Vec::new(),
        }
    }

    fn sixteen(developer: &Developer<'_>, samples: &[f32]) -> Vec<u16> {
        let mut pixels = Pixels::Sixteen(vec![7; 4]);
        developer.develop(samples, &PIXEL, &mut pixels);
        let Pixels::Sixteen(pixels) = pixels else { unreachable!() };
        pixels
    }

    #[test]
    fn samples_are_averaged_as_light_and_not_as_codes() {
        let half_white = [[1.0; 4], [0.0, 0.0, 0.0, 1.0], [1.0; 4], [0.0, 0.0, 0.0, 1.0]].concat();
        let found = sixteen(&developer(2, false), &half_white);
        // Half the light of white is code 188 of 255.
        assert!(found[..3].iter().all(|&c| (f32::from(c) / 65535.0 - 0.7354).abs() < 1e-3) && found[3] == 65535, "{found:?}");
    }

    #[test]
    fn half_covered_pixels_look_right_before_black_and_empty_ones_are_clear() {
        let before_black = |pixel: &[u16]| f32::from(pixel[0]) * f32::from(pixel[3]) / 65535.0;
        let glow = sixteen(&developer(1, true), &[0.2, 0.2, 0.2, 0.4]);
        assert!(
            (before_black(&glow) - 0.2 * 65535.0).abs() < 2.0 && (f32::from(glow[3]) - 0.4 * 65535.0).abs() < 1.0,
            "{glow:?}"
        );
        let bright = sixteen(&developer(1, true), &[0.9, 0.9, 0.9, 0.1]);
        assert!((before_black(&bright) - 0.9 * 65535.0).abs() < 2.0, "{bright:?}");
        assert_eq!(sixteen(&developer(1, true), &[0.9, 0.9, 0.9, 0.0]), [0; 4]);
        assert_eq!(sixteen(&developer(1, false), &[0.0, 0.0, 0.0, 0.0]), [0, 0, 0, 65535]);
    }
}
