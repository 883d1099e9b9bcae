//! Pictures on disk: whole or not at all.

use anyhow::{ensure, Context as _};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use terrane::stills::{Pixels, Still};

/// Writes an RGBA picture as an RGB PNG.
pub(crate) fn write_png(path: &Path, size: [u32; 2], rgba: &[u8]) -> anyhow::Result<()> {
    write_channels(path, size, png::BitDepth::Eight, rgba, 1, false)
}

/// Writes a still as a PNG of 8 or 16 bits, with alpha if that is wanted.
pub(crate) fn write_still(path: &Path, still: &Still, alpha: bool) -> anyhow::Result<()> {
    match &still.pixels {
        Pixels::Eight(rgba) => write_channels(path, still.size, png::BitDepth::Eight, rgba, 1, alpha),
        Pixels::Sixteen(rgba) => {
            let bytes: Vec<u8> = rgba.iter().flat_map(|channel| channel.to_be_bytes()).collect();
            write_channels(path, still.size, png::BitDepth::Sixteen, &bytes, 2, alpha)
        }
        Pixels::Radiance(_) => anyhow::bail!("radiance does not fit into a PNG; please report this"),
    }
}

/// Writes RGBA of so many bytes a channel, row by row.
fn write_channels(
    path: &Path,
    [width, height]: [u32; 2],
    depth: png::BitDepth,
    rgba: &[u8],
    bytes: usize,
    alpha: bool,
) -> anyhow::Result<()> {
    ensure!(rgba.len() == 4 * bytes * width as usize * height as usize, "a picture of the wrong length; please report this");
    write_whole_with(path, |file| {
        let mut encoder = png::Encoder::new(file, width, height);
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
        writer.finish()?;
        Ok(())
    })
}

/// Writes a file under a temporary name and moves it into place.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_whole_with(path, |file| Ok(file.write_all(bytes)?))
}

/// Writes a file with `write` under a temporary name and moves it into place.
pub(crate) fn write_whole_with(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let name = path.file_name().with_context(|| format!("{} names no file", path.display()))?;
    let part = path.with_file_name(format!(".{}.part", name.to_string_lossy()));
    let create = || -> anyhow::Result<()> {
        let mut file = BufWriter::new(File::create(&part)?);
        write(&mut file)?;
        file.flush()?;
        Ok(std::fs::rename(&part, path)?)
    };
    let written = create();
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    written
}
