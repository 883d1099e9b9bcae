//! Stills as PNG files of 8 or 16 bits a channel.

use super::{Pixels, Still};
use std::io::{self, Write};

impl Still {
    /// Writes the picture as a PNG: RGBA if it was drawn with a transparent sky, RGB otherwise.
    ///
    /// # Errors
    /// Those of the writer; and for radiance, which no PNG holds.
    pub fn write_png(&self, to: impl Write) -> io::Result<()> {
        match &self.pixels {
            Pixels::Eight(rgba) => write_channels(to, self.size, png::BitDepth::Eight, rgba, 1, self.transparent),
            Pixels::Sixteen(rgba) => {
                let bytes: Vec<u8> = rgba.iter().flat_map(|channel| channel.to_be_bytes()).collect();
                write_channels(to, self.size, png::BitDepth::Sixteen, &bytes, 2, self.transparent)
            }
            Pixels::Radiance(_) => {
                Err(io::Error::new(io::ErrorKind::InvalidInput, "radiance does not fit into a PNG; draw display values"))
            }
        }
    }
}

/// Writes an RGBA picture of 8 bits a channel as an RGB PNG.
///
/// # Errors
/// Those of the writer; and if there are not 4 bytes for every pixel.
pub fn write_rgb_png(to: impl Write, size: [u32; 2], rgba: &[u8]) -> io::Result<()> {
    write_channels(to, size, png::BitDepth::Eight, rgba, 1, false)
}

/// Writes RGBA of so many bytes a channel, row by row, with or without its alpha.
fn write_channels(
    to: impl Write,
    [width, height]: [u32; 2],
    depth: png::BitDepth,
    rgba: &[u8],
    bytes: usize,
    alpha: bool,
) -> io::Result<()> {
    let expected = 4 * bytes * width as usize * height as usize;
    if rgba.len() != expected {
        let message = format!("a picture of {width}x{height} with {} bytes, expected {expected}", rgba.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(if alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(depth);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    for row in rgba.chunks_exact(4 * bytes * width as usize) {
        if alpha {
            stream.write_all(row)?;
        } else {
            let rgb: Vec<u8> = row.chunks_exact(4 * bytes).flat_map(|pixel| &pixel[..3 * bytes]).copied().collect();
            stream.write_all(&rgb)?;
        }
    }
    stream.finish()?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        write_rgb_png(&mut file, [2, 1], &rgba).unwrap();
        assert_eq!(decoded(&file), (png::ColorType::Rgb, png::BitDepth::Eight, vec![1, 2, 3, 5, 6, 7]));
        let mut file = Vec::new();
        write_channels(&mut file, [1, 1], png::BitDepth::Sixteen, &rgba, 2, true).unwrap();
        assert_eq!(decoded(&file), (png::ColorType::Rgba, png::BitDepth::Sixteen, rgba.to_vec()));
    }

    #[test]
    fn pictures_of_the_wrong_length_are_refused() {
        let mut file = Vec::new();
        assert!(write_rgb_png(&mut file, [2, 2], &[0; 8]).is_err() && file.is_empty());
    }
}
