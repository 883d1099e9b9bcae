//! Pictures on disk.

use anyhow::Context as _;
use std::io::Write;
use std::path::Path;

/// Writes an RGBA picture as an RGB PNG, whole or not at all.
pub(crate) fn write_png(path: &Path, [width, height]: [u32; 2], rgba: &[u8]) -> anyhow::Result<()> {
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&rgb)?;
    write_whole(path, &bytes)
}

/// Writes a file under a temporary name and moves it into place.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let name = path.file_name().with_context(|| format!("{} names no file", path.display()))?;
    let part = path.with_file_name(format!(".{}.part", name.to_string_lossy()));
    let written =
        std::fs::File::create(&part).and_then(|mut file| file.write_all(bytes)).and_then(|()| std::fs::rename(&part, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    Ok(written?)
}
