//! Recipes that come with the library, whatever folder a program runs in. In: a name. Out: the recipe, of the same text and images as the
//! file in `recipes/`, and so the same planet to the bit.

use super::{Asset, Recipe, RecipeError};

/// A recipe's name, its text, and the images that the text names.
type Shipped = (&'static str, &'static str, &'static [(&'static str, &'static [u8])]);

const SHIPPED: [Shipped; 6] = [
    ("terra", include_str!("../../recipes/terra.toml"), &[]),
    ("luna", include_str!("../../recipes/luna.toml"), &[]),
    ("mars", include_str!("../../recipes/mars.toml"), &[]),
    ("tiny", include_str!("../../recipes/tiny.toml"), &[]),
    (
        "jacksboro",
        include_str!("../../recipes/jacksboro.toml"),
        &[("jacksboro_fault_dem.tif", include_bytes!("../../recipes/jacksboro_fault_dem.tif"))],
    ),
    (
        "earth",
        include_str!("../../recipes/earth.toml"),
        &[
            ("earth-topology.png", include_bytes!("../../recipes/earth-topology.png")),
            ("earth-blue-marble.jpg", include_bytes!("../../recipes/earth-blue-marble.jpg")),
        ],
    ),
];

/// Their names.
pub fn names() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, ..)| *name)
}

/// The recipe of one of [`names`].
///
/// # Errors
/// [`RecipeError::NotShipped`] for any other name.
pub fn load(name: &str) -> Result<Recipe, RecipeError> {
    let Some((_, text, images)) = SHIPPED.iter().find(|(shipped, ..)| *shipped == name) else {
        let names: Vec<&str> = names().collect();
        return Err(RecipeError::NotShipped { name: name.into(), names: names.join(", ").into() });
    };
    let assets = images.iter().map(|(name, bytes)| Asset { name: (*name).to_owned(), bytes: bytes.to_vec() });
    Recipe::from_parts(text, &format!("{name}.toml"), assets.collect())
}
