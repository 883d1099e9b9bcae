//! Single-band TIFFs, plain or GeoTIFF: numbers of any type in strips or tiles, plain, deflated, LZW or ZSTD, read chunk by chunk
//! so that a window of a large file takes the memory of the window. In: a file. Out: its heights, upright, with its place.

use super::geotiff::{Part, Tags, Turned};
use super::metadata::Band;
use super::tiff_samples::{self, Layout};
use super::{Fault, Format, ImportError, Imported, Source, Window};
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use tiff::decoder::{ifd::Value, Decoder, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

/// The bytes of a TIFF: in memory, or in a file of which only parts are read.
pub(super) enum Input<'a> {
    Memory(Cursor<&'a [u8]>),
    File(BufReader<File>),
}

pub(super) type Tiff<'a> = Decoder<Input<'a>>;

/// Longest value of a tag in bytes, the lists of strips and tiles among them; the decoder refuses longer ones.
const LONGEST_TAG: usize = 1 << 23;

/// Images of a file that are looked at for overviews and masks.
const MOST_IMAGES: usize = 64;

/// Values of the tags of compression that are named in messages.
const LERC: u16 = 34_887;

/// What is said where the decoder refuses.
pub(super) const EXPECTED: &str = "an undamaged TIFF of one band, uncompressed, deflate, LZW or ZSTD";

impl Read for Input<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Input::Memory(bytes) => bytes.read(buffer),
            Input::File(file) => file.read(buffer),
        }
    }
}

impl Seek for Input<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        match self {
            Input::Memory(bytes) => bytes.seek(to),
            Input::File(file) => file.seek(to),
        }
    }
}

/// Reads a TIFF: its first image, or one of its overviews.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let damaged = |e: TiffError| refused(source, &e);
    let mut file = Decoder::new(open(source)?).map_err(damaged)?;
    let tags = Tags::read(&mut file);
    let band = band(source, &mut file, &tags)?;
    let full = size(source, &mut file)?;
    let masked = seek(source, &mut file)?;
    let own = size(source, &mut file)?;
    let window = source.options.part(source, own)?;
    let samples = if window == Window::whole(own) { source.check_size(own)? } else { source.check_part(window.size())? };
    let layout = layout(source, &mut file, own, window)?;
    // A strip holds at most the image, a tile at most a little more than that.
    let most = 8 * 4 * samples.max(own[0]).max(1 << 20);
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size, limits.ifd_value_size) = (most, most, LONGEST_TAG);
    let mut file = file.with_limits(limits);
    let no_data = no_data(source, &mut file)?;
    let mut read = tiff_samples::read(source, &mut file, &layout, no_data, &band)?;
    turn(&mut read.heights, window.columns, tags.turned());
    let mut image = Imported::new(source, Format::Tiff, read.values, window.size(), read.heights)?;
    image.declared_no_data = no_data;
    image.notes.extend(read.notes);
    if masked {
        image.notes.push("its mask is not looked at: make it a no-data value, for instance with gdalwarp -dstnodata".into());
    }
    let factor = [full[0] as f64 / own[0] as f64, full[1] as f64 / own[1] as f64];
    let mut image = tags.georeferenced(source, image, Part { window, factor });
    note_feet(&mut image, &band);
    Ok(image)
}

/// An error of the decoder.
pub(super) fn refused(source: &Source, error: &TiffError) -> ImportError {
    let fault = if matches!(error, TiffError::UnsupportedError(_)) { Fault::Kind } else { Fault::Damaged };
    source.refuse(fault, error.to_string(), EXPECTED)
}

fn open<'a>(source: &Source<'a>) -> Result<Input<'a>, ImportError> {
    let Some(path) = source.path else { return Ok(Input::Memory(Cursor::new(source.bytes))) };
    let file = File::open(path).map_err(|e| source.refuse(Fault::Unreadable, e.to_string(), "a readable file"))?;
    Ok(Input::File(BufReader::new(file)))
}

fn size(source: &Source, file: &mut Tiff) -> Result<[usize; 2], ImportError> {
    let (columns, rows) = file.dimensions().map_err(|e| refused(source, &e))?;
    if columns == 0 || rows == 0 {
        return Err(source.refuse(Fault::Size, format!("{columns} x {rows} samples"), "at least 2 x 2"));
    }
    Ok([columns as usize, rows as usize])
}

/// Scale, offset and unit of the numbers.
fn band(source: &Source, file: &mut Tiff, tags: &Tags) -> Result<Band, ImportError> {
    let text = file.get_tag_ascii_string(Tag::Unknown(42_112)).unwrap_or_default();
    let band = Band::of_metadata(&text);
    let mut band = band.map_err(|found| source.refuse(Fault::Kind, found, "numbers and units of length in tag 42112"))?;
    if band.unit_m.is_none() {
        band.unit_m = tags.height_unit_m(source)?;
    }
    Ok(band)
}

/// Goes to the image that is wanted. Out: whether the first one has a mask beside it.
fn seek(source: &Source, file: &mut Tiff) -> Result<bool, ImportError> {
    let (mut masked, mut overviews) = (false, 0);
    for image in 1..MOST_IMAGES {
        if !file.more_images() || file.next_image().is_err() {
            break;
        }
        let kind = file.find_tag_unsigned::<u32>(Tag::NewSubfileType).ok().flatten().unwrap_or(0);
        masked |= kind & 5 == 4;
        if kind & 5 == 1 {
            overviews += 1;
            if source.options.overview == Some(overviews) {
                file.seek_to_image(image).map_err(|e| refused(source, &e))?;
                return Ok(masked);
            }
        }
    }
    if let Some(wanted) = source.options.overview.filter(|&wanted| wanted > 0) {
        let error = source.refuse(Fault::Size, format!("{overviews} overviews"), format!("overview {wanted}"));
        return Err(error.with_advice("make some with gdaladdo, or take a part (--window COLUMN,ROW,COLUMNS,ROWS)"));
    }
    file.seek_to_image(0).map_err(|e| refused(source, &e))?;
    Ok(masked)
}

/// How samples are stored, if they can be heights.
fn layout(source: &Source, file: &mut Tiff, size: [usize; 2], window: Window) -> Result<Layout, ImportError> {
    let damaged = |e: TiffError| refused(source, &e);
    if file.find_tag_unsigned::<u16>(Tag::Compression).ok().flatten() == Some(LERC) {
        let error = source.refuse(Fault::Kind, "LERC compression", "none, deflate, LZW or ZSTD");
        return Err(error.with_advice("write it again: gdal_translate -co COMPRESS=ZSTD in.tif out.tif keeps every digit"));
    }
    let photometric = file.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).ok().flatten();
    if photometric == Some(3) {
        return Err(source.refuse(Fault::Kind, "a palette", "one band of heights").with_advice(PALETTE));
    }
    let colour = file.colortype().map_err(damaged)?;
    match (photometric, colour, source.options.encoding) {
        (Some(0), ..) => {
            let error = source.refuse(Fault::Kind, "an image whose 0 is white", "numbers that rise with height");
            return Err(error.with_advice("write it again with gdal_translate -co PHOTOMETRIC=MINISBLACK"));
        }
        (_, ColorType::RGB(8) | ColorType::RGBA(8), Some(_)) | (_, ColorType::Gray(8 | 16 | 32 | 64), None) => (),
        (_, colour, Some(_)) => {
            let error =
                source.refuse(Fault::Kind, format!("{colour:?}"), "red, green and blue of 8 bits, which --encoding is about");
            return Err(error.with_advice("leave --encoding away"));
        }
        (_, colour @ (ColorType::RGB(_) | ColorType::RGBA(_)), None) => {
            return Err(source.refuse(Fault::Kind, format!("{colour:?}"), "one band of heights").with_advice(COLOURS));
        }
        (_, colour, None) => {
            let advice = "take the band that holds heights: gdal_translate -b 1 in.tif out.tif";
            return Err(source.refuse(Fault::Kind, format!("{colour:?}"), "one band of heights").with_advice(advice));
        }
    }
    let (width, height) = file.chunk_dimensions();
    let chunk = [width as usize, height as usize];
    if width == 0 || height == 0 {
        return Err(source.refuse(Fault::Damaged, format!("tiles of {width} x {height}"), "tiles or strips that are not empty"));
    }
    let bytes = file.get_tag_u64_vec(Tag::TileByteCounts).or_else(|_| file.get_tag_u64_vec(Tag::StripByteCounts));
    let channels = usize::from(colour.num_samples());
    Ok(Layout { size, window, channels, chunk, bytes: bytes.map_err(damaged)? })
}

/// What to do with colours, and with palettes.
pub(super) const COLOURS: &str =
    "heights coded as colours need --encoding terrarium or mapbox; a picture of heights holds none: \
                                  take the elevation model that it was drawn from";
pub(super) const PALETTE: &str =
    "the colours of a palette are a legend and no heights: take the elevation model that it was drawn from";

/// The declared no-data value, if any.
fn no_data(source: &Source, file: &mut Tiff) -> Result<Option<f64>, ImportError> {
    let Ok(Some(Value::Ascii(text))) = file.find_tag(Tag::GdalNodata) else { return Ok(None) };
    let text = text.trim_matches(['\0', ' ']);
    let number = text.parse::<f64>();
    number.map(Some).map_err(|_| source.refuse(Fault::Damaged, format!("no-data value '{text}'"), "a number in tag 42113"))
}

/// Turns rows north and columns east.
pub(super) fn turn<T>(samples: &mut [T], columns: usize, turned: Turned) {
    if turned.rows {
        let rows = samples.len() / columns;
        for row in 0..rows / 2 {
            let (above, below) = samples.split_at_mut((rows - 1 - row) * columns);
            above[row * columns..][..columns].swap_with_slice(&mut below[..columns]);
        }
    }
    if turned.columns {
        samples.chunks_exact_mut(columns).for_each(<[T]>::reverse);
    }
}

/// A map in feet whose heights have no unit: says what they are taken as.
fn note_feet(image: &mut Imported, band: &Band) {
    let in_feet = image.georeference.as_ref().is_some_and(|place| place.unit.contains("foot"));
    if in_feet && band.unit_m.is_none() {
        image.notes.push("states no unit of heights: taken as metres (--height-scale 0.3048 for feet)".into());
    }
}
