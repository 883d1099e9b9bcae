//! Pictures of the ground as its colours, over the whole planet, at a placed rectangle, or where the file says. In: a file's bytes and a
//! placement. Out: for each point a colour and how much it counts.

mod mips;
pub(super) mod srgb;
pub(super) mod water;

use super::albedo::{ColourLanes, Site};
use super::heightmap::footprint::Footprint;
use super::layer::{Evaluate, Past};
use super::octaves::Ramp;
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, PictureFile, Recipe, RecipeError};
use mips::Mips;
use std::f64::consts::PI;
use terrane_heightfield::import::photo::{self, Photo};

/// A decoded picture.
pub(crate) struct Imagery {
    mips: Mips,
    footprint: Footprint,
    /// Metres on the ground between neighbouring rows.
    pitch_m: f64,
    strength: f32,
    brighten: f32,
    radius: f64,
}

/// Pixels of a level between samples: splines blur by about half a pixel, which is then finer than the samples show.
const SHARPNESS: f64 = 0.6;

/// Reads a picture that a recipe names.
pub(super) fn picture(file: &PictureFile, recipe: &Recipe) -> Result<Photo, RecipeError> {
    let asset = recipe.assets.iter().find(|a| a.name == file.name);
    let asset = asset.ok_or_else(|| recipe.picture_error(file, "no such asset".into(), "its bytes among the assets"))?;
    photo::read(&asset.bytes, &asset.name).map_err(|e| {
        recipe.picture_error(file, e.found.into(), &format!("{}; save it again as JPEG, PNG or TIFF of 8-bit RGB", e.expected))
    })
}

impl Evaluate for Imagery {
    type Recipe = recipe::Imagery;

    fn new(_: u64, imagery: &recipe::Imagery, recipe: &Recipe) -> Result<Self, RecipeError> {
        let photo = picture(&imagery.file, recipe)?;
        let footprint = Footprint::new(&photo.green, &imagery.placement, recipe.radius)
            .map_err(|(found, expected)| recipe.picture_error(&imagery.file, found, &expected))?;
        let (size, wraps) = (photo.size(), footprint.wraps());
        let counts = imagery.water.then(|| water::land_counts(&photo.pixels, size, wraps));
        let pitch_m = footprint.row_pitch_m().unwrap_or(PI * recipe.radius / size[1] as f64);
        let (strength, brighten, radius) = (imagery.strength as f32, imagery.brighten as f32, recipe.radius);
        Ok(Self { mips: Mips::new(size, photo.pixels, counts, wraps), footprint, pitch_m, strength, brighten, radius })
    }

    /// It has none.
    #[inline(always)]
    fn metres(&self, _: &Points, _: &mut Past) -> Option<Lane> {
        None
    }

    fn range(&self, _: f64) -> (f64, f64) {
        (0.0, 0.0)
    }
}

impl Imagery {
    /// Colours the dry ground of a chunk: the picture's colours, brightened and darkened by `light`. Steep ground keeps some of the palette's
    /// rock where samples stand much closer than pixels.
    pub(super) fn paint(&self, p: &Points, site: &Site, light: &Lane, out: &mut ColourLanes) {
        const STEEP: Ramp = Ramp::new([0.5, 1.1]);
        const BARE: f32 = 0.6;
        for i in 0..LANES {
            if site.above[i] < 0.0 {
                continue;
            }
            let Some((colour, weight)) = self.at([0, 1, 2].map(|k| p.position[k][i] / self.radius), f64::from(site.spacing[i]))
            else {
                continue;
            };
            let near = 1.0 - (site.spacing[i] / (0.02 * self.pitch_m as f32)).min(1.0);
            let share = weight * self.strength * (1.0 - BARE * near * STEEP.at(site.slope[i]));
            for k in 0..3 {
                out[k][i] += (colour[k] * light[i] - out[k][i]) * share;
            }
        }
    }

    /// sRGB-encoded colour (0 to 255) at a unit direction, where samples stand `spacing` metres apart, and its weight from 0 to 1; nothing
    /// outside the picture.
    pub(crate) fn at(&self, d: [f64; 3], spacing: f64) -> Option<([f32; 3], f32)> {
        let spot = self.footprint.locate(d)?;
        let light = self.mips.at([spot.column, spot.row], SHARPNESS * spacing / self.pitch_m);
        // Brightens what is dark, and leaves black and white what they are.
        let light = light.map(|l| self.brighten * l / (1.0 + (self.brighten - 1.0) * l));
        Some((self.mips.encoded(light), spot.weight as f32))
    }
}
