//! The `[clouds]` table of a recipe. In: the table. Out: [`Clouds`].

use super::error::RecipeError;
use super::reader::Reader;

/// A sheet of cloud at one height.
#[derive(Clone, Debug, PartialEq)]
pub struct Clouds {
    /// Height above the datum in metres.
    pub height_m: f64,
    /// Share of the planet that it covers, 0 to 1.
    pub cover: f64,
    /// Optical depth where it is thickest.
    pub optical_depth: f64,
}

impl Clouds {
    pub(super) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let clouds = Self {
            height_m: reader.number_or("height_m", 1.0..=1e6, 5500.0)?,
            cover: reader.number_or("cover", 0.0..=1.0, 0.5)?,
            optical_depth: reader.number_or("optical_depth", 0.0..=1000.0, 30.0)?,
        };
        reader.finish()?;
        Ok(clouds)
    }
}

#[cfg(test)]
mod tests {
    use crate::recipe::Recipe;
    use std::path::Path;

    #[test]
    fn clouds_are_optional_and_checked() {
        let read = |table: &str| {
            let text = format!("{}\n{table}", include_str!("../../recipes/tiny.toml"));
            Recipe::from_toml(&text, "tiny.toml", Path::new("")).map_err(|e| e.to_string())
        };
        assert!(read("").unwrap().clouds.is_none());
        let clouds = read("[clouds]\ncover = 0.3\nheight_m = 900.0").unwrap().clouds.unwrap();
        assert_eq!((clouds.cover, clouds.height_m, clouds.optical_depth), (0.3, 900.0, 30.0));
        assert!(read("[clouds]\ncover = 1.3").unwrap_err().contains("cover"));
    }
}
