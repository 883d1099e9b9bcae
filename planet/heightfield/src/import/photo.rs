//! Pictures of the ground: JPEG, PNG and (Geo)TIFF of 8 bits, in colours or grey.
//!
//! In: a file's bytes and its name. Out: sRGB-encoded pixels, north row first, and what the file says about where they lie; or what was
//! found and what was expected. Bytes from outside never panic.

use super::geotiff::{Part, Tags};
use super::tiff::{turn, Input};
use super::{Fault, Format, ImportError, Imported, Options, Source, Values, Window, MOST_SAMPLES};
use png::{BitDepth, ColorType, Decoder, Transformations};
use std::io::Cursor;
use tiff::decoder::{DecodingResult, Limits};
use tiff::ColorType as TiffColour;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// What a picture may be, in messages.
const EXPECTED: &str = "a JPEG, PNG or TIFF picture of 8 bits a channel, in RGB or grey";

/// Most pixels that a byte of a picture can stand for: those of files that say more are not there.
const MOST_PIXELS_PER_BYTE: usize = 1 << 13;

/// Longest value of a TIFF's tag in bytes.
const LONGEST_TAG: usize = 1 << 23;

/// Why a picture was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: found {found}, expected {expected}; save it again as JPEG, PNG or TIFF of 8-bit RGB")]
pub struct PhotoError {
    /// The file's name.
    pub file: Box<str>,
    /// What was found.
    pub found: Box<str>,
    /// What was expected.
    pub expected: Box<str>,
}

/// A picture of the ground.
#[derive(Clone, Debug)]
pub struct Photo {
    /// sRGB-encoded pixels, row by row from the north.
    pub pixels: Vec<[u8; 3]>,
    /// Its green channel as a field, with what the file says about where that lies.
    pub green: Imported,
}

impl Photo {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.green.field.columns(), self.green.field.rows()]
    }
}

/// A picture that is being read.
struct File<'a> {
    source: Source<'a>,
}

impl File<'_> {
    fn refuse(&self, found: impl Into<Box<str>>, expected: impl Into<Box<str>>) -> PhotoError {
        PhotoError { file: self.source.name.into(), found: found.into(), expected: expected.into() }
    }

    fn damaged(&self, error: &dyn std::fmt::Display, format: &str) -> PhotoError {
        self.refuse(error.to_string(), format!("an undamaged {format} of 8 bits a channel, in RGB or grey"))
    }

    fn colours(&self, found: String) -> PhotoError {
        self.refuse(found, EXPECTED)
    }

    /// Checks the size that a file states, before memory is taken for it. Out: the number of pixels.
    fn check_size(&self, [columns, rows]: [usize; 2]) -> Result<usize, PhotoError> {
        let found = format!("{columns} x {rows} pixels");
        if columns < 2 || rows < 2 {
            return Err(self.refuse(found, "at least 2 x 2"));
        }
        let pixels = columns.checked_mul(rows).filter(|&p| p <= MOST_SAMPLES);
        let pixels = pixels.ok_or_else(|| self.refuse(found.as_str(), format!("at most {MOST_SAMPLES}")))?;
        if pixels / MOST_PIXELS_PER_BYTE > self.source.bytes.len() {
            let found = format!("{found} stated in a file of {} bytes", self.source.bytes.len());
            return Err(self.refuse(found, "a file that can hold them"));
        }
        Ok(pixels)
    }

    /// The picture of bytes with so many channels a pixel, of which the first or the first three count.
    fn picture(&self, format: Format, size: [usize; 2], bytes: &[u8], channels: usize) -> Result<Photo, PhotoError> {
        let colour = |pixel: &[u8]| if channels < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
        let pixels: Vec<[u8; 3]> = bytes.chunks_exact(channels).map(colour).collect();
        let green = pixels.iter().map(|pixel| f32::from(pixel[1])).collect();
        let green = Imported::new(&self.source, format, Values::Levels { full: 255.0 }, size, green);
        Ok(Photo { green: green.map_err(|e| self.import(&e))?, pixels })
    }

    fn import(&self, error: &ImportError) -> PhotoError {
        let expected = if error.fault == Fault::Damaged { EXPECTED } else { &error.expected };
        self.refuse(error.found.as_ref(), expected)
    }
}

/// Reads a picture; the format follows from its first bytes.
///
/// # Errors
/// For bytes that are none of these formats, damaged, of more than 8 bits a channel or of other colours than RGB and grey, smaller than
/// 2 × 2, or of more than [`MOST_SAMPLES`] pixels.
pub fn read(bytes: &[u8], name: &str) -> Result<Photo, PhotoError> {
    let options = Options::default();
    let file = File { source: Source::of_bytes(name, bytes, &options) };
    match bytes {
        [0xff, 0xd8, 0xff, ..] => jpeg(&file),
        [0x89, b'P', b'N', b'G', ..] => portable(&file),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tagged(&file),
        _ => Err(file.refuse(format!("first bytes {:02x?}", &bytes[..bytes.len().min(4)]), EXPECTED)),
    }
}

fn jpeg(file: &File) -> Result<Photo, PhotoError> {
    // Strict: what is cut off would else be grey ground. The limits are those of `check_size`, which comes too late for the headers.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(1 << 16)
        .set_max_height(1 << 16)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let damaged = |e: zune_jpeg::errors::DecodeErrors| file.damaged(&e, "JPEG");
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(file.source.bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let (columns, rows) = decoder.dimensions().ok_or_else(|| file.damaged(&"no size", "JPEG"))?;
    let pixels = file.check_size([columns, rows])?;
    match decoder.input_colorspace() {
        Some(ColorSpace::RGB | ColorSpace::YCbCr | ColorSpace::Luma) => {}
        other => return Err(file.colours(format!("a JPEG of colours {other:?}"))),
    }
    let bytes = decoder.decode().map_err(damaged)?;
    if bytes.len() != 3 * pixels {
        return Err(file.damaged(&format!("{} bytes of {columns} x {rows} pixels", bytes.len()), "JPEG"));
    }
    // Heights know no JPEG: the field beside the colours is only for its size.
    file.picture(Format::Raw, [columns, rows], &bytes, 3)
}

fn portable(file: &File) -> Result<Photo, PhotoError> {
    let damaged = |e: png::DecodingError| file.damaged(&e, "PNG");
    let mut decoder = Decoder::new(Cursor::new(file.source.bytes));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = [reader.info().width as usize, reader.info().height as usize];
    let pixels = file.check_size(size)?;
    let (colour, depth) = reader.output_color_type();
    let channels = match (colour, depth) {
        (ColorType::Rgb | ColorType::Rgba | ColorType::Grayscale | ColorType::GrayscaleAlpha, BitDepth::Eight) => {
            colour.samples()
        }
        _ => return Err(file.colours(format!("a PNG of colour type {colour:?} of {} bits", depth as u8))),
    };
    let mut bytes = vec![0; pixels * channels];
    reader.next_frame(&mut bytes).map_err(damaged)?;
    file.picture(Format::Png, size, &bytes, channels)
}

fn tagged(file: &File) -> Result<Photo, PhotoError> {
    let damaged = |e: tiff::TiffError| file.damaged(&e, "TIFF (plain, deflate or LZW)");
    let memory = Input::Memory(Cursor::new(file.source.bytes));
    let mut decoder = tiff::decoder::Decoder::new(memory).map_err(damaged)?;
    let (columns, rows) = decoder.dimensions().map_err(damaged)?;
    let size = [columns as usize, rows as usize];
    let pixels = file.check_size(size)?;
    let channels = match decoder.colortype().map_err(damaged)? {
        TiffColour::Gray(8) => 1,
        TiffColour::RGB(8) => 3,
        TiffColour::RGBA(8) => 4,
        other => return Err(file.colours(format!("a TIFF of colours {other:?}"))),
    };
    let most = 4 * pixels.max(1 << 22);
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size, limits.ifd_value_size) = (most, most, LONGEST_TAG);
    let mut decoder = decoder.with_limits(limits);
    let tags = Tags::read(&mut decoder);
    let bytes = match decoder.read_image().map_err(damaged)? {
        DecodingResult::U8(bytes) if bytes.len() == pixels * channels => bytes,
        _ => return Err(file.damaged(&"samples missing, or of another type", "TIFF")),
    };
    let bytes = upright(bytes, channels, size[0], &tags);
    let photo = file.picture(Format::Tiff, size, &bytes, channels)?;
    let part = Part { window: Window::whole(size), factor: [1.0; 2] };
    Ok(Photo { green: tags.georeferenced(&file.source, photo.green, part), ..photo })
}

/// The bytes with the north row and the west column first.
fn upright(bytes: Vec<u8>, channels: usize, columns: usize, tags: &Tags) -> Vec<u8> {
    let mut pixels: Vec<&[u8]> = bytes.chunks_exact(channels).collect();
    turn(&mut pixels, columns, tags.turned());
    pixels.concat()
}
