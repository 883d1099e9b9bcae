//! Stills as PNG files of 8 or 16 bits a channel, with their view as text.

use super::{Pixels, Still};
use std::io::{self, BufRead, Seek, Write};
use terrane_planet::draw::view_line::ViewLine;

/// Keyword of the PNG text that holds the view of a picture.
pub const VIEW_KEYWORD: &str = "Terrane view";

impl Still {
    /// Writes the picture as a PNG: RGBA if it was drawn with a transparent sky, RGB otherwise.
    ///
    /// # Errors
    /// Those of the writer; and for radiance, which no PNG holds.
    pub fn write_png(&self, to: impl Write) -> io::Result<()> {
        self.write(to, None)
    }

    /// Writes the picture as [`Still::write_png`] does, with its view as text, which [`read_view`] finds.
    ///
    /// # Errors
    /// As [`Still::write_png`].
    pub fn write_png_of(&self, to: impl Write, view: &ViewLine) -> io::Result<()> {
        self.write(to, Some(view))
    }

    fn write(&self, to: impl Write, view: Option<&ViewLine>) -> io::Result<()> {
        let channels = |depth, bytes: &[u8], each| {
            let channels = Channels { size: self.size, depth, bytes, each, alpha: self.transparent };
            channels.write(to, view)
        };
        match &self.pixels {
            Pixels::Eight(rgba) => channels(png::BitDepth::Eight, rgba, 1),
            Pixels::Sixteen(rgba) => {
                let bytes: Vec<u8> = rgba.iter().flat_map(|channel| channel.to_be_bytes()).collect();
                channels(png::BitDepth::Sixteen, &bytes, 2)
            }
            Pixels::Radiance(_) => {
                Err(io::Error::new(io::ErrorKind::InvalidInput, "radiance does not fit into a PNG; draw display values"))
            }
        }
    }
}

/// Writes an RGBA picture of 8 bits a channel as an RGB PNG, with its view as text if it has one.
///
/// # Errors
/// Those of the writer; and if there are not 4 bytes for every pixel.
pub fn write_rgb_png(to: impl Write, size: [u32; 2], rgba: &[u8], view: Option<&ViewLine>) -> io::Result<()> {
    Channels { size, depth: png::BitDepth::Eight, bytes: rgba, each: 1, alpha: false }.write(to, view)
}

/// The text of the view that a PNG was drawn from, as [`Still::write_png_of`] writes it; `None` if there is none in it.
///
/// # Errors
/// Those of the reader, and if it reads no PNG.
pub fn read_view(from: impl BufRead + Seek) -> io::Result<Option<String>> {
    let mut reader = png::Decoder::new(from).read_info()?;
    // Programs that change metadata may put it behind the pixels.
    if reader.info().uncompressed_latin1_text.is_empty() {
        reader.finish()?;
    }
    let texts = &reader.info().uncompressed_latin1_text;
    Ok(texts.iter().find(|text| text.keyword == VIEW_KEYWORD).map(|text| text.text.clone()))
}

/// RGBA, row by row.
struct Channels<'a> {
    size: [u32; 2],
    depth: png::BitDepth,
    bytes: &'a [u8],
    /// Bytes a channel.
    each: usize,
    /// Whether alpha is written.
    alpha: bool,
}

impl Channels<'_> {
    fn write(&self, to: impl Write, view: Option<&ViewLine>) -> io::Result<()> {
        let ([width, height], pixel) = (self.size, 4 * self.each);
        let expected = pixel * width as usize * height as usize;
        if self.bytes.len() != expected {
            let message = format!("a picture of {width}x{height} with {} bytes, expected {expected}", self.bytes.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let mut encoder = png::Encoder::new(to, width, height);
        encoder.set_color(if self.alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(self.depth);
        if let Some(view) = view {
            encoder.add_text_chunk(VIEW_KEYWORD.to_owned(), view.to_string())?;
        }
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        for row in self.bytes.chunks_exact(pixel * width as usize) {
            if self.alpha {
                stream.write_all(row)?;
            } else {
                let rgb: Vec<u8> = row.chunks_exact(pixel).flat_map(|pixel| &pixel[..3 * self.each]).copied().collect();
                stream.write_all(&rgb)?;
            }
        }
        stream.finish()?;
        Ok(writer.finish()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::draw::view_line::Stand;

    fn decoded(bytes: &[u8]) -> (png::ColorType, png::BitDepth, Vec<u8>) {
        let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.color_type, info.bit_depth, pixels)
    }

    #[test]
    fn pictures_keep_their_channels() {
        let rgba = [1, 2, 3, 4, 5, 6, 7, 8];
        let mut file = Vec::new();
        write_rgb_png(&mut file, [2, 1], &rgba, None).unwrap();
        assert_eq!(decoded(&file), (png::ColorType::Rgb, png::BitDepth::Eight, vec![1, 2, 3, 5, 6, 7]));
        assert_eq!(read_view(io::Cursor::new(&file)).unwrap(), None);
        let mut file = Vec::new();
        let channels = Channels { size: [1, 1], depth: png::BitDepth::Sixteen, bytes: &rgba, each: 2, alpha: true };
        let view = ViewLine::from_site([1.0, 2.0], Stand::Altitude(3.0));
        channels.write(&mut file, Some(&view)).unwrap();
        assert_eq!(read_view(io::Cursor::new(&file)).unwrap(), Some(view.to_string()));
        assert_eq!(decoded(&file), (png::ColorType::Rgba, png::BitDepth::Sixteen, rgba.to_vec()));
    }

    #[test]
    fn pictures_of_the_wrong_length_are_refused() {
        let mut file = Vec::new();
        assert!(write_rgb_png(&mut file, [2, 2], &[0; 8], None).is_err() && file.is_empty());
    }
}
