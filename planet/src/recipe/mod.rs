//! A planet's recipe: TOML text and the images it names, range-checked. In: text, or a file. Out: a [`Recipe`], from
//! which [`crate::terrain::Terrain`] is built. Keys, units and ranges are documented in `recipes/README.md`.

mod atmosphere;
mod clouds;
mod edit;
mod error;
mod layer;
mod palette;
mod place;
mod reader;
pub mod shipped;

pub use atmosphere::Atmosphere;
pub use clouds::Clouds;
pub use edit::{Edit, EditRange, Shape};
pub use error::RecipeError;
pub(crate) use layer::layer_kinds;
pub use layer::*;
pub use palette::{Airless, Colour, Desert, Living, Palette};
pub use place::{ground_text, Place, PlaceError};

use crate::globe::sun::EARTH_TILT;
use reader::{Reader, Source};
use std::path::Path;

/// Reflectance that pictures show as white, where a recipe says nothing: that of snow and of thick cloud.
const WHITE: f64 = 0.85;

/// A sea of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Sea {
    /// Surface, in metres relative to the planet's radius.
    pub level_m: f64,
    /// Colour of shallow water, linear RGB reflectance from 0 to 1.
    pub shallow: [f64; 3],
    /// Colour of deep water, linear RGB reflectance from 0 to 1.
    pub deep: [f64; 3],
    /// Ground within about this many metres of the level is flattened into beaches and shelves (0: not at all).
    pub beach_m: f64,
}

/// A file that the recipe refers to, as its raw bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asset {
    /// The name by which the recipe refers to it.
    pub name: String,
    /// The file, unchanged.
    pub bytes: Vec<u8>,
}

/// Everything that decides a planet.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The planet's name.
    pub name: String,
    /// Radius of the datum, in metres (1000 to 1e8).
    pub radius: f64,
    /// Tilt of the axis against the year, in degrees (0 to 180).
    pub axial_tilt: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// Reflectance that pictures show as white (0.05 to 1). It decides no ground.
    pub white: f64,
    /// The sea, if any.
    pub sea: Option<Sea>,
    /// The atmosphere, if any.
    pub atmosphere: Option<Atmosphere>,
    /// The clouds, if any.
    pub clouds: Option<Clouds>,
    /// Layers of the terrain, in the order in which they are composed.
    pub layers: Vec<Layer>,
    /// Changes of the ground after all layers, in order.
    pub edits: Vec<Edit>,
    /// Ground colours.
    pub palette: Palette,
    /// Views worth a visit. They decide nothing of the planet, and planets that differ in nothing else are the same.
    pub places: Vec<Place>,
    /// The text this recipe was read from.
    pub text: String,
    /// The files that the text names, in order of first use.
    pub assets: Vec<Asset>,
    /// The recipe's name in messages.
    pub(crate) file: String,
}

impl Recipe {
    /// Reads a recipe file and the images beside it.
    ///
    /// # Errors
    /// If the file cannot be read, or as [`Recipe::from_toml`].
    pub fn load(path: &Path) -> Result<Self, RecipeError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| RecipeError::Read { file: file.as_str().into(), source })?;
        Self::from_toml(&text, &file, path.parent().unwrap_or(Path::new("")))
    }

    /// Parses and range-checks. `name` is used in messages; `base` is the folder that image names are relative to.
    ///
    /// # Errors
    /// For text that is not TOML, for unknown or missing keys, wrong types, values out of range (with file, line, key
    /// path, found and expected), and for images that cannot be read.
    pub fn from_toml(text: &str, name: &str, base: &Path) -> Result<Self, RecipeError> {
        let mut recipe = Self::parse(text, name)?;
        for map in recipe.heightmaps() {
            for file in &map.files {
                if recipe.assets.iter().any(|a| a.name == *file) {
                    continue;
                }
                let path = base.join(file);
                let bytes = std::fs::read(&path)
                    .map_err(|e| recipe.heightmap_error(&map, format!("{e} at {}", path.display()), "a readable file"))?;
                recipe.assets.push(Asset { name: file.clone(), bytes });
            }
        }
        for picture in recipe.pictures() {
            if recipe.assets.iter().any(|a| a.name == picture.name) {
                continue;
            }
            let path = base.join(&picture.name);
            let bytes = std::fs::read(&path)
                .map_err(|e| recipe.picture_error(&picture, format!("{e} at {}", path.display()), "a readable file"))?;
            recipe.assets.push(Asset { name: picture.name, bytes });
        }
        Ok(recipe)
    }

    /// Rebuilds a recipe from its text and assets alone, as a planet file stores them.
    ///
    /// # Errors
    /// As [`Recipe::from_toml`], and if an image that the text names is not among the assets.
    pub fn from_parts(text: &str, name: &str, assets: Vec<Asset>) -> Result<Self, RecipeError> {
        let mut recipe = Self::parse(text, name)?;
        for map in recipe.heightmaps() {
            if !map.files.iter().all(|file| assets.iter().any(|a| a.name == *file)) {
                return Err(recipe.heightmap_error(&map, "no such asset".into(), "its bytes among the assets"));
            }
        }
        for picture in recipe.pictures() {
            if !assets.iter().any(|a| a.name == picture.name) {
                return Err(recipe.picture_error(&picture, "no such asset".into(), "its bytes among the assets"));
            }
        }
        recipe.assets = assets;
        Ok(recipe)
    }

    fn parse(text: &str, file: &str) -> Result<Self, RecipeError> {
        let source = Source { file, text };
        let document = toml::de::DeTable::parse(text).map_err(|e| RecipeError::Syntax {
            file: file.into(),
            line: source.line(e.span().map_or(0, |s| s.start)),
            message: e.message().into(),
        })?;
        let reader = Reader::new(&source, document.get_ref());
        let radius = reader.number("radius_m", 1e3..=1e8)?;
        let axial_tilt = reader.number_or("axial_tilt_deg", 0.0..=180.0, EARTH_TILT)?;
        let name = reader.string("name", "the planet's name")?;
        let seed = reader.whole("seed")?;
        let white = reader.number_or("white", 0.05..=1.0, WHITE)?;
        let sea = reader.table("sea")?.map(|r| Sea::read(&r)).transpose()?;
        let atmosphere = reader.table("atmosphere")?.map(|r| Atmosphere::read(&r)).transpose()?;
        let clouds = reader.table("clouds")?.map(|r| Clouds::read(&r)).transpose()?;
        let layers = reader.tables("layer")?.iter().map(|r| Layer::read(r, radius)).collect::<Result<_, _>>()?;
        let edits = reader.tables("edit")?.iter().map(|r| Edit::read(r, radius)).collect::<Result<_, _>>()?;
        let palette = reader.table("palette")?.ok_or_else(|| reader.wrong("palette", 1, "nothing", "a table"))?;
        let palette = Palette::read(&palette)?;
        let places = Place::read_all(&reader, text)?;
        reader.finish()?;
        let (text, file) = (text.to_owned(), file.to_owned());
        Ok(Self {
            name,
            radius,
            axial_tilt,
            seed,
            white,
            sea,
            atmosphere,
            clouds,
            layers,
            edits,
            palette,
            places,
            text,
            assets: Vec::new(),
            file,
        })
    }

    /// The same planet with one edit more, at the end of its text.
    ///
    /// # Errors
    /// If a number of the edit is out of range, or if nothing can follow the text.
    pub fn with_edit(&self, edit: &Edit) -> Result<Self, RecipeError> {
        Self::from_parts(&(self.text.clone() + &edit.text()), &self.file, self.assets.clone())
    }

    /// The planet as it was before [`Recipe::with_edit`], to the very text. `None` if no edit ends the text: there is none, or it was
    /// written by hand.
    ///
    /// # Errors
    /// As [`Recipe::from_parts`].
    pub fn without_last_edit(&self) -> Result<Option<Self>, RecipeError> {
        let before = self.edits.last().and_then(|last| self.text.strip_suffix(&last.text()));
        before.map(|text| Self::from_parts(text, &self.file, self.assets.clone())).transpose()
    }

    /// How many edits [`Recipe::without_last_edit`] takes away, one after the other.
    pub fn undoable_edits(&self) -> usize {
        let mut text = self.text.as_str();
        let ends = self.edits.iter().rev().map_while(|edit| {
            text = text.strip_suffix(&edit.text())?;
            Some(())
        });
        ends.count()
    }

    /// The place that a name means: its own or, if only one place has it, the beginning of it, in small or capital letters.
    ///
    /// # Errors
    /// If no place or several are meant, with the names that there are.
    pub fn place(&self, name: &str) -> Result<&Place, PlaceError> {
        Place::find(&self.places, &self.name, name)
    }

    /// Metres above the datum of what lies uppermost where the ground is `ground_m` metres above it: the ground, or the sea that covers it.
    pub fn ground_or_sea(&self, ground_m: f64) -> f64 {
        self.sea.as_ref().map_or(ground_m, |sea| ground_m.max(sea.level_m))
    }

    fn heightmaps(&self) -> Vec<Heightmap> {
        let maps = self.layers.iter().filter_map(|l| if let Layer::Heightmap(m) = l { Some(m.clone()) } else { None });
        maps.collect()
    }

    fn pictures(&self) -> Vec<PictureFile> {
        let file = |layer: &Layer| match layer {
            Layer::Imagery(imagery) => Some(imagery.file.clone()),
            Layer::Seabed(seabed) => Some(seabed.file.clone()),
            _ => None,
        };
        self.layers.iter().filter_map(file).collect()
    }

    /// An error about a picture, at the line of its `file` key.
    pub(crate) fn picture_error(&self, picture: &PictureFile, found: String, expected: &str) -> RecipeError {
        RecipeError::Picture {
            file: self.file.as_str().into(),
            line: picture.origin.0,
            path: picture.origin.1.as_str().into(),
            image: picture.name.as_str().into(),
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// An error about a heightmap's image, at the line of its `file` key.
    pub(crate) fn heightmap_error(&self, map: &Heightmap, found: String, expected: &str) -> RecipeError {
        RecipeError::Heightmap {
            file: self.file.as_str().into(),
            line: map.origin.0,
            path: map.origin.1.as_str().into(),
            image: map.files.join(", ").into(),
            found: found.into(),
            expected: expected.into(),
        }
    }
}

impl Sea {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let sea = Self {
            level_m: reader.number_or("level_m", -1e5..=1e5, 0.0)?,
            shallow: reader.numbers("shallow", 0.0..=1.0)?,
            deep: reader.numbers("deep", 0.0..=1.0)?,
            beach_m: reader.number_or("beach_m", 0.0..=1000.0, 0.0)?,
        };
        reader.finish()?;
        Ok(sea)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whites_are_optional_and_checked() {
        let read = |line: &str| {
            let text = include_str!("../../recipes/tiny.toml").replace("seed = 7", &format!("seed = 7\n{line}"));
            Recipe::from_toml(&text, "tiny.toml", Path::new("")).map_err(|e| e.to_string())
        };
        assert_eq!((read("").unwrap().white, read("white = 0.3").unwrap().white), (WHITE, 0.3));
        for wrong in ["white = 1.1", "white = 0", "white = [0.5]"] {
            assert!(read(wrong).unwrap_err().contains("white"), "{wrong}");
        }
    }
}
