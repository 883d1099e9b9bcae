//! Greyscale PNGs of 8 or 16 bits: levels from black to white, north row first.

use super::{Fault, Format, ImportError, Imported, Source, Values};
use png::{BitDepth, ColorType, Decoder};
use std::io::Cursor;

/// Reads a PNG.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let damaged = |e: png::DecodingError| source.refuse(Fault::Damaged, e.to_string(), "an undamaged PNG");
    let mut reader = Decoder::new(Cursor::new(source.bytes)).read_info().map_err(damaged)?;
    let info = reader.info();
    let wide = match (info.color_type, info.bit_depth) {
        (ColorType::Grayscale, BitDepth::Sixteen) => true,
        (ColorType::Grayscale, BitDepth::Eight) => false,
        (colour, depth) => {
            let found = format!("colour type {colour:?} of {} bits", depth as u8);
            return Err(source.refuse(Fault::Kind, found, "greyscale of 16 or 8 bits without alpha"));
        }
    };
    let size = [info.width as usize, info.height as usize];
    let samples = source.check_size(size)?;
    let mut raw = vec![0; if wide { 2 * samples } else { samples }];
    reader.next_frame(&mut raw).map_err(damaged)?;
    let heights: Vec<f32> = if wide {
        raw.chunks_exact(2).map(|b| f32::from(u16::from_be_bytes([b[0], b[1]]))).collect()
    } else {
        raw.into_iter().map(f32::from).collect()
    };
    Imported::new(source, Format::Png, Values::Levels { full: if wide { 65_535.0 } else { 255.0 } }, size, heights)
}
