//! Parameters of pictures of the ground with units and ranges: which file, where it lies, how much it counts. In: one `[[layer]]` table.
//! Out: the checked layer.

use super::{Placement, ReadLayer, UNIT};
use crate::recipe::error::RecipeError;
use crate::recipe::reader::Reader;

/// A picture that colours the ground where it lies.
#[derive(Clone, Debug)]
pub struct Imagery {
    /// The picture.
    pub file: PictureFile,
    /// Where it lies.
    pub placement: Placement,
    /// How much its colours count against the palette's (0 to 1; default 1).
    pub strength: f64,
    /// How much brighter dark colours become (0.25 to 4; default 1): pictures are often darker than the ground.
    pub brighten: f64,
    /// Whether its blue pixels are water, which colours no land (default false).
    pub water: bool,
}

/// The name of a picture in a recipe.
#[derive(Clone, Debug)]
pub struct PictureFile {
    /// The file's name, relative to the recipe.
    pub name: String,
    /// Line and path of the `file` key, for messages.
    pub(crate) origin: (usize, String),
}

impl PictureFile {
    pub(super) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let name = reader.string("file", "the name of a picture: JPEG, PNG or TIFF")?;
        Ok(Self { name, origin: (reader.line_of("file"), reader.path_of("file")) })
    }
}

impl ReadLayer for Imagery {
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        Ok(Self {
            file: PictureFile::read(reader)?,
            placement: Placement::read(reader, radius)?,
            strength: reader.number_or("strength", UNIT, 1.0)?,
            brighten: reader.number_or("brighten", 0.25..=4.0, 1.0)?,
            water: reader.flag("water")?,
        })
    }
}
