//! Pictures on disk: whole or not at all.

use anyhow::Context as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use terrane::stills::{write_rgb_png, Still};
use terrane_planet::draw::view_line::ViewLine;

/// Writes an RGBA picture as an RGB PNG, with its view if it has one.
pub(crate) fn write_png(path: &Path, size: [u32; 2], rgba: &[u8], view: Option<&ViewLine>) -> anyhow::Result<()> {
    write_whole_with(path, |file| Ok(write_rgb_png(file, size, rgba, view)?))
}

/// Writes a still as a PNG of 8 or 16 bits, with alpha if it was drawn with a transparent sky.
pub(crate) fn write_still(path: &Path, still: &Still) -> anyhow::Result<()> {
    write_whole_with(path, |file| Ok(still.write_png(file)?))
}

/// Writes a still as [`write_still`] does, with its view.
pub(crate) fn write_still_of(path: &Path, still: &Still, view: &ViewLine) -> anyhow::Result<()> {
    write_whole_with(path, |file| Ok(still.write_png_of(file, view)?))
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
