//! PNGs: levels from black to white of 8 or 16 bits, or colours that stand for heights; north row first. What is fully transparent
//! is a gap.

use super::gaps::Gaps;
use super::tiff::{COLOURS, PALETTE};
use super::{Fault, Format, ImportError, Imported, Source, Values};
use png::{BitDepth, ColorType, Decoder};
use std::io::Cursor;

/// How a pixel is stored.
struct Pixel {
    channels: usize,
    bytes: usize,
    alpha: bool,
}

/// Reads a PNG.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let damaged = |e: png::DecodingError| source.refuse(Fault::Damaged, e.to_string(), "an undamaged PNG");
    let mut reader = Decoder::new(Cursor::new(source.bytes)).read_info().map_err(damaged)?;
    let info = reader.info();
    let pixel = pixel(source, info.color_type, info.bit_depth)?;
    let size = [info.width as usize, info.height as usize];
    let samples = source.check_size(size)?;
    let mut raw = vec![0; pixel.bytes * pixel.channels * samples];
    reader.next_frame(&mut raw).map_err(damaged)?;
    let (values, heights) = heights(source, &pixel, &raw);
    Imported::new(source, Format::Png, values, size, heights)
}

fn pixel(source: &Source, colour: ColorType, depth: BitDepth) -> Result<Pixel, ImportError> {
    let found = || format!("colour type {colour:?} of {} bits", depth as u8);
    let coded = source.options.encoding.is_some();
    match (colour, depth) {
        (ColorType::Grayscale, BitDepth::Sixteen) if !coded => Ok(Pixel { channels: 1, bytes: 2, alpha: false }),
        (ColorType::Grayscale, BitDepth::Eight) if !coded => Ok(Pixel { channels: 1, bytes: 1, alpha: false }),
        (ColorType::GrayscaleAlpha, BitDepth::Sixteen) if !coded => Ok(Pixel { channels: 2, bytes: 2, alpha: true }),
        (ColorType::GrayscaleAlpha, BitDepth::Eight) if !coded => Ok(Pixel { channels: 2, bytes: 1, alpha: true }),
        (ColorType::Rgb, BitDepth::Eight) if coded => Ok(Pixel { channels: 3, bytes: 1, alpha: false }),
        (ColorType::Rgba, BitDepth::Eight) if coded => Ok(Pixel { channels: 4, bytes: 1, alpha: true }),
        (ColorType::Rgb | ColorType::Rgba, _) if !coded => {
            Err(source.refuse(Fault::Kind, found(), "greyscale of 16 or 8 bits").with_advice(COLOURS))
        }
        (ColorType::Indexed, _) => Err(source.refuse(Fault::Kind, found(), "greyscale of 16 or 8 bits").with_advice(PALETTE)),
        _ if coded => {
            let error = source.refuse(Fault::Kind, found(), "red, green and blue of 8 bits, which --encoding is about");
            Err(error.with_advice("leave --encoding away"))
        }
        _ => {
            let error = source.refuse(Fault::Kind, found(), "greyscale of 16 or 8 bits");
            Err(error.with_advice("export it again with 16 bits"))
        }
    }
}

fn heights(source: &Source, pixel: &Pixel, raw: &[u8]) -> (Values, Vec<f32>) {
    let gaps = Gaps::new(source, None);
    let stride = pixel.channels * pixel.bytes;
    let height = |p: &[u8]| {
        let transparent = pixel.alpha && p[stride - pixel.bytes..].iter().all(|&byte| byte == 0);
        let number = match (source.options.encoding, pixel.bytes) {
            (Some(encoding), _) => encoding.metres([p[0], p[1], p[2]]),
            (None, 1) => f32::from(p[0]),
            (None, _) => f32::from(u16::from_be_bytes([p[0], p[1]])),
        };
        if transparent || gaps.holds(f64::from(number), true) {
            f32::NAN
        } else {
            number
        }
    };
    let values = match (source.options.encoding, pixel.bytes) {
        (Some(_), _) => Values::Metres,
        (None, 1) => Values::Levels { full: 255.0 },
        (None, _) => Values::Levels { full: 65_535.0 },
    };
    (values, raw.chunks_exact(stride).map(height).collect())
}
