//! Still pictures of any size: by tiles, supersampled, of 8 or 16 bits or as radiance.
//!
//! In: a settled scene, a view and its cut. Out: [`Still`]. All tiles show one mesh, selected for the whole picture, through windows of one
//! camera: the tolerance counts in pixels of the picture, and no seam shows.

mod develop;
mod png;
mod tiles;

pub use develop::Pixels;
pub use png::{read_view, write_rgb_png, VIEW_KEYWORD};

use crate::frame::Look;
use crate::headless::{FrameReport, Headless};
use crate::scene::{Scene, SceneError};
use crate::vulkan::Context;
use develop::Developer;
use half::f16;
use std::sync::Arc;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::{Mode, EDGE_REACH};
use terrane_planet::draw::tone::Curve;
use terrane_planet::draw::view::{View, Window};

/// Side in pixels of the largest tile unless told otherwise: 150 MB of images.
pub const TILE: u32 = 2048;

/// Least and most side of a tile.
pub const TILE_RANGE: (u32, u32) = (64, 8192);

/// Samples a pixel in each direction, at most.
pub const MOST_SSAA: u32 = 4;

/// Most pixels a side of the picture that exposure is metered in before one is drawn by tiles.
const METERED_SIDE: u32 = 1024;

/// Pixels around each tile that its edges may depend on: how far their ends are looked for, and what tells surfaces apart. Even, as
/// pixels are shaded in squares of two.
const EDGE_MARGIN: u32 = EDGE_REACH as u32 + 4;

/// What the pixels of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Display values of 8 bits, dithered.
    Eight,
    /// Display values of 16 bits.
    Sixteen,
    /// Radiance as half floats.
    Radiance,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StillOptions {
    /// Samples a pixel in each direction, from 1 to [`MOST_SSAA`].
    pub ssaa: u32,
    /// Most pixels of a tile's side, samples counted, within [`TILE_RANGE`]; with one sample a pixel what is drawn for its edges around
    /// each tile comes on top.
    pub tile: u32,
    /// What the pixels are.
    pub format: PixelFormat,
    /// Whether alpha is 0 where there is neither ground nor sea nor air; in the air alone it is the share of light that does not pass.
    /// Without it alpha is 1 everywhere.
    pub transparent: bool,
}

impl Default for StillOptions {
    fn default() -> StillOptions {
        StillOptions { ssaa: 1, tile: TILE, format: PixelFormat::Eight, transparent: false }
    }
}

impl StillOptions {
    /// Whether pixels that show two surfaces are mixed: not where there are several samples anyway, and not in radiance.
    fn has_edges(&self) -> bool {
        self.ssaa == 1 && self.format != PixelFormat::Radiance
    }
}

/// A picture and what it took.
pub struct Still {
    /// Width and height.
    pub size: [u32; 2],
    /// The pixels.
    pub pixels: Pixels,
    /// Whether their alpha says anything.
    pub transparent: bool,
    /// Factor from radiance to what the tone curve took.
    pub exposure: f32,
    /// The tone curve.
    pub curve: Curve,
    /// The frame; times are the sums over all tiles.
    pub report: FrameReport,
    /// Triangles that did not fit into the index buffer, over all tiles.
    pub dropped_triangles: u64,
    /// How many tiles there were.
    pub tiles: usize,
}

/// Draws pictures of one size, one after the other.
pub struct Studio {
    headless: Headless,
    /// Width and height of what is drawn at once, in samples.
    raster: (u32, u32),
    /// The parts of the picture, and what is drawn of each.
    windows: Vec<[Window; 2]>,
    size: [u32; 2],
    options: StillOptions,
}

impl Studio {
    /// Pipelines and targets for pictures of a size.
    pub fn new(context: &Arc<Context>, size: [u32; 2], options: StillOptions) -> Result<Studio, SceneError> {
        let options = StillOptions {
            ssaa: options.ssaa.clamp(1, MOST_SSAA),
            tile: options.tile.clamp(TILE_RANGE.0, TILE_RANGE.1).min(context.limits().max_image_dimension2_d - 2 * EDGE_MARGIN),
            ..options
        };
        let kept = tiles::windows(size, options.ssaa, options.tile);
        let drawn = tiles::drawn(&kept, size, if options.has_edges() { EDGE_MARGIN } else { 0 });
        let [width, height] = drawn[0].size.map(|side| side * options.ssaa);
        let windows = kept.into_iter().zip(drawn).map(<[Window; 2]>::from).collect();
        let mut headless = Headless::new(context, (width, height))?;
        headless.renderer.starry = !options.transparent;
        Ok(Studio { headless, raster: (width, height), windows, size, options })
    }

    /// Sets for how many seconds waves have run.
    pub fn set_time(&mut self, seconds: f64) {
        self.headless.renderer.time = seconds;
    }

    /// Draws a picture of a view of this size. `progress` is told how many tiles of how many are done.
    pub fn draw(
        &mut self,
        scene: &Scene,
        view: &View,
        cut: &Cut,
        look: &Look,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Still, SceneError> {
        let count = 4 * self.size[0] as usize * self.size[1] as usize;
        let mut pixels = match self.options.format {
            PixelFormat::Eight => Pixels::Eight(vec![0; count]),
            PixelFormat::Sixteen => Pixels::Sixteen(vec![0; count]),
            PixelFormat::Radiance => Pixels::Radiance(vec![f16::ZERO; count]),
        };
        let curve = Curve::new(look.tone, scene.planet().recipe.white);
        let whole = self.windows.len() == 1;
        let look = &if whole { *look } else { self.metered(scene, view, cut, look)? };
        let mut report = match whole {
            true => self.headless.render(scene, view, cut, look)?,
            false => self.headless.select_seen(scene, view, cut, look)?,
        };
        let mut dropped_triangles = if whole { dropped(&report.counters) } else { 0 };
        for (done, windows) in self.windows.iter().enumerate() {
            if !whole {
                let (times, counters) = self.headless.render_part(scene, &view.through(windows[1]), &report.tables, look)?;
                report.times.zones.extend(times.zones);
                report.times.wall_ms += times.wall_ms;
                dropped_triangles += dropped(&counters);
            }
            self.take(windows, look.mode, curve, &mut pixels)?;
            progress(done + 1, self.windows.len());
        }
        let exposure = self.headless.exposure()?;
        let transparent = self.options.transparent;
        Ok(Still { size: self.size, pixels, transparent, exposure, curve, report, dropped_triangles, tiles: self.windows.len() })
    }

    /// The look with its exposure changed as a small picture of the whole view asks for: tiles metered by themselves would differ.
    fn metered(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look) -> Result<Look, SceneError> {
        if look.metering.is_none() {
            return Ok(*look);
        }
        let larger = self.size[0].max(self.size[1]).div_ceil(METERED_SIDE);
        let [width, height] = self.size.map(|side| side.div_ceil(larger));
        self.headless.resize((width, height))?;
        self.headless.render(scene, view, cut, look)?;
        let exposure = look.exposure * self.headless.metered()?;
        self.headless.resize(self.raster)?;
        Ok(Look { exposure, metering: None, ..*look })
    }

    /// Fills a window's pixels from what was drawn last.
    fn take(&self, windows: &[Window; 2], mode: Mode, curve: Curve, pixels: &mut Pixels) -> Result<(), SceneError> {
        let StillOptions { ssaa, transparent, .. } = self.options;
        match pixels {
            // What windows show.
            Pixels::Eight(all) if ssaa == 1 && !transparent => copy_tile(&self.headless.pixels()?, windows, all, self.size),
            _ => {
                let exposure = self.headless.exposure()?;
                let has_edges = self.options.has_edges() && !mode.is_plain();
                let edges = if has_edges { self.headless.edges()? } else { Vec::new() };
                let [kept, drawn] = windows;
                let developer = Developer { mode, exposure, curve, ssaa, transparent, picture: self.size, drawn, edges };
                developer.develop(&self.headless.radiance()?, kept, pixels);
            }
        }
        Ok(())
    }
}

fn dropped(counters: &terrane_planet::draw::layout::EmitState) -> u64 {
    u64::from(counters.wanted.saturating_sub(counters.capacity))
}

/// Copies what is kept of a tile to where it lies in the picture.
fn copy_tile(tile: &[u8], [kept, drawn]: &[Window; 2], all: &mut [u8], picture: [u32; 2]) {
    let [left, top, width, skipped] =
        [kept.origin[0], kept.origin[1], drawn.size[0], kept.origin[0] - drawn.origin[0]].map(|n| 4 * n as usize);
    let seen = 4 * kept.size[0].min(picture[0] - kept.origin[0]) as usize;
    let rows = all.chunks_exact_mut(4 * picture[0] as usize).skip(top / 4).take(kept.size[1] as usize);
    let from = tile.chunks_exact(width).skip((kept.origin[1] - drawn.origin[1]) as usize);
    for (row, from) in rows.zip(from) {
        row[left..][..seen].copy_from_slice(&from[skipped..][..seen]);
    }
}
