//! Frames of a camera path side by side in one picture. In: frames of one size. Out: a PNG, or a JPEG.

use super::output::{check_output, Output};
use super::pictures;
use anyhow::{bail, ensure, Context as _};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use std::path::{Path, PathBuf};
use terrane::stills::{Pixels, Still};

/// White between frames, in pixels.
const GAP: usize = 4;
/// Quality of JPEGs, of 100: nothing is seen of it beside the PNG.
const QUALITY: u8 = 90;
/// Widest strip in pixels: what JPEGs can be.
const WIDEST: u32 = 65_535;

/// A strip in the making.
pub(crate) struct Strip {
    out: PathBuf,
    /// Width and height of a frame.
    frame: [usize; 2],
    width: usize,
    rgba: Vec<u8>,
}

impl Strip {
    /// So many frames of a size. Fails at once where the picture cannot be written.
    pub(crate) fn new(out: &Path, size: [u32; 2], count: u32) -> anyhow::Result<Strip> {
        check_output("--out", out, Output::File(&["png", "jpg"]))?;
        let width = u64::from(size[0]) * u64::from(count) + GAP as u64 * u64::from(count - 1);
        ensure!(width <= u64::from(WIDEST), "--strip: {count} frames of {} pixels are wider than {WIDEST}", size[0]);
        let frame = size.map(|side| side as usize);
        Ok(Strip { out: out.to_owned(), frame, width: width as usize, rgba: vec![255; 4 * width as usize * frame[1]] })
    }

    /// Puts the frame of a number, from 1, in its place.
    pub(crate) fn add(&mut self, number: usize, still: &Still) -> anyhow::Result<()> {
        let Pixels::Eight(rgba) = &still.pixels else { bail!("a frame that is not of 8 bits; please report this") };
        let [width, _] = self.frame;
        let left = 4 * (number - 1) * (width + GAP);
        for (row, line) in rgba.chunks_exact(4 * width).enumerate() {
            let at = 4 * row * self.width + left;
            self.rgba[at..at + 4 * width].copy_from_slice(line);
        }
        Ok(())
    }

    /// Writes the picture.
    pub(crate) fn finish(&self) -> anyhow::Result<()> {
        let (width, height) = (self.width, self.frame[1]);
        if self.out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return pictures::write_png(&self.out, [width as u32, height as u32], &self.rgba, None);
        }
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, QUALITY);
        encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
        encoder.encode(&self.rgba, width as u16, height as u16, ColorType::Rgba).context("cannot encode the strip")?;
        pictures::write_whole(&self.out, &bytes).with_context(|| format!("cannot write {}", self.out.display()))
    }
}
