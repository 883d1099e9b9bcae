//! Greyscale TIFFs, plain or GeoTIFF: 16-bit integers or 32-bit floats in strips or tiles, uncompressed, deflated or LZW.
//! Signed integers and floats are metres, unsigned integers levels. A no-data value stands in GDAL's tag 42113.

use super::{geotiff, Fault, Format, ImportError, Imported, Source, Values};
use std::io::Cursor;
use tiff::decoder::{ifd::Value, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

pub(super) type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

/// Longest value of a tag in bytes, the lists of strips and tiles among them; the decoder refuses longer ones.
const LONGEST_TAG: usize = 1 << 23;

const EXPECTED: &str = "one band of 16-bit integers or 32-bit floats";

/// Reads a TIFF; only its first image.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let damaged = |e: TiffError| {
        let fault = if matches!(e, TiffError::UnsupportedError(_)) { Fault::Kind } else { Fault::Damaged };
        source.refuse(fault, e.to_string(), format!("an undamaged TIFF of {EXPECTED}, uncompressed, deflate or LZW"))
    };
    let mut file = Decoder::new(Cursor::new(source.bytes)).map_err(damaged)?;
    let (columns, rows) = file.dimensions().map_err(damaged)?;
    let size = [columns as usize, rows as usize];
    let samples = source.check_size(size)?;
    let colour = file.colortype().map_err(damaged)?;
    let (ColorType::Gray(16) | ColorType::Gray(32)) = colour else {
        return Err(source.refuse(Fault::Kind, format!("{colour:?}"), EXPECTED));
    };
    // A strip holds at most the image, a tile at most a little more than that.
    let most = 4 * samples.max(1 << 22);
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size, limits.ifd_value_size) = (most, most, LONGEST_TAG);
    let mut file = file.with_limits(limits);
    let no_data = no_data(source, &mut file)?;
    let (values, heights) = samples_of(source, &mut file, size, no_data, damaged)?;
    let image = Imported::new(source, Format::Tiff, values, size, heights)?;
    Ok(geotiff::georeferenced(image, &mut file))
}

/// The declared no-data value, if any.
fn no_data(source: &Source, file: &mut Tiff) -> Result<Option<f64>, ImportError> {
    let Ok(Some(Value::Ascii(text))) = file.find_tag(Tag::GdalNodata) else { return Ok(None) };
    let text = text.trim_matches(['\0', ' ']);
    let number = text.parse::<f64>();
    number.map(Some).map_err(|_| source.refuse(Fault::Damaged, format!("no-data value '{text}'"), "a number in tag 42113"))
}

/// All samples, strip by strip or tile by tile.
fn samples_of(
    source: &Source,
    file: &mut Tiff,
    [columns, rows]: [usize; 2],
    no_data: Option<f64>,
    damaged: impl Fn(TiffError) -> ImportError,
) -> Result<(Values, Vec<f32>), ImportError> {
    let (width, height) = file.chunk_dimensions();
    let (width, height) = (width as usize, height as usize);
    if width == 0 || height == 0 {
        return Err(source.refuse(Fault::Damaged, format!("tiles of {width} x {height}"), "tiles or strips that are not empty"));
    }
    let (across, down) = (columns.div_ceil(width), rows.div_ceil(height));
    let mut heights = vec![f32::NAN; columns * rows];
    let mut values = Values::Metres;
    for (down, across) in (0..down).flat_map(|d| (0..across).map(move |a| (d, a))) {
        let chunk = (down * columns.div_ceil(width) + across) as u32;
        let (chunk_values, numbers) = numbers(source, file.read_chunk(chunk).map_err(&damaged)?)?;
        values = chunk_values;
        let (wide, _) = file.chunk_data_dimensions(chunk);
        let lines = numbers.chunks_exact(wide as usize).enumerate();
        for (line, numbers) in lines.take_while(|(line, _)| down * height + line < rows) {
            let (column, row) = (across * width, down * height + line);
            for (k, &number) in numbers.iter().take(columns - column).enumerate() {
                let height = sample(number, no_data);
                heights[row * columns + column + k] = height.ok_or_else(|| {
                    let found = format!("{number} at column {}, row {row}", column + k);
                    source.refuse(Fault::Sample, found, "finite heights, or a declared no-data value")
                })?;
            }
        }
    }
    Ok((values, heights))
}

/// The numbers of a strip or tile, and what they mean.
fn numbers(source: &Source, decoded: DecodingResult) -> Result<(Values, Vec<f32>), ImportError> {
    Ok(match decoded {
        DecodingResult::U16(levels) => (Values::Levels { full: 65_535.0 }, levels.into_iter().map(f32::from).collect()),
        DecodingResult::I16(metres) => (Values::Metres, metres.into_iter().map(f32::from).collect()),
        DecodingResult::F32(metres) => (Values::Metres, metres),
        _ => return Err(source.refuse(Fault::Kind, "samples of another type", EXPECTED)),
    })
}

/// A height, NaN for no data, nothing for what is neither.
fn sample(number: f32, no_data: Option<f64>) -> Option<f32> {
    match no_data {
        Some(declared) if declared.is_nan() && number.is_nan() => Some(f32::NAN),
        // Declared in decimals, which may round to the float next to the one that is meant: compare as floats.
        Some(declared) if declared as f32 == number => Some(f32::NAN),
        _ => Some(number).filter(|n| n.is_finite()),
    }
}
