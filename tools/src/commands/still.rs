//! How still pictures are made, as options that commands share.

use anyhow::bail;
use std::path::Path;
use terrane::stills::{PixelFormat, StillOptions, MOST_SSAA, TILE, TILE_RANGE};
use terrane_planet::draw::view_line::ViewLine;

/// How a picture is drawn.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct StillArguments {
    /// Samples a pixel in each direction, 1 to 4: 2 draws the picture twice as wide and high and filters it [default: 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SSAA)))]
    ssaa: Option<u32>,
    /// Most pixels a side that are drawn at once, 64 to 8192, samples counted: larger pictures are drawn by tiles, which shows nowhere.
    /// Smaller tiles take less memory and more time.
    #[arg(long, value_name = "PX", default_value_t = TILE,
        value_parser = clap::value_parser!(u32).range(i64::from(TILE_RANGE.0)..=i64::from(TILE_RANGE.1)))]
    tile: u32,
    /// Write alpha: 0 where there is neither ground nor sea nor air, and the share of light that does not pass where there is only air.
    #[arg(long)]
    pub(crate) transparent_sky: bool,
}

impl StillArguments {
    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        self.ssaa = self.ssaa.or(line.ssaa);
        self.transparent_sky |= line.transparent_sky;
    }

    /// Puts into a view what is not as usual.
    pub(crate) fn note(&self, line: &mut ViewLine) {
        line.ssaa = Some(self.ssaa()).filter(|samples| *samples != 1);
        line.transparent_sky = self.transparent_sky;
    }

    /// Samples a pixel in each direction.
    pub(crate) fn ssaa(self) -> u32 {
        self.ssaa.unwrap_or(1)
    }

    /// With pixels of a format.
    pub(crate) fn options(self, format: PixelFormat) -> StillOptions {
        StillOptions { ssaa: self.ssaa(), tile: self.tile, format, transparent: self.transparent_sky }
    }
}

/// What a file of a name holds: of a PNG `depth` bits, 8 unless told otherwise.
pub(crate) fn format_of(out: &Path, depth: Option<u32>) -> anyhow::Result<PixelFormat> {
    let extension = out.extension().map(|e| e.to_string_lossy().to_lowercase());
    Ok(match (extension.as_deref(), depth) {
        (Some("png"), None | Some(8)) => PixelFormat::Eight,
        (Some("png"), Some(16)) => PixelFormat::Sixteen,
        (Some("png"), Some(other)) => bail!("--depth: {other} bits, expected 8 or 16"),
        (Some("exr"), None) => PixelFormat::Radiance,
        (Some("exr"), Some(_)) => bail!("--depth is for PNG: an EXR picture always holds half floats; leave it out"),
        _ => bail!("--out: {} is neither a .png nor an .exr", out.display()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_decide_formats() {
        let of = |name: &str, depth| format_of(Path::new(name), depth).map_err(|e| e.to_string());
        assert_eq!(of("a.png", None), Ok(PixelFormat::Eight));
        assert_eq!(of("a.PNG", Some(16)), Ok(PixelFormat::Sixteen));
        assert_eq!(of("a.exr", None), Ok(PixelFormat::Radiance));
        for (name, depth, part) in
            [("a.png", Some(12), "8 or 16"), ("a.exr", Some(16), "half floats"), ("a.tif", None, "a.tif"), ("a", None, "neither")]
        {
            assert!(of(name, depth).unwrap_err().contains(part), "{name}");
        }
    }
}
