//! Recipes that commands take: files, and those that come with the command.

use anyhow::Context as _;
use std::path::Path;
use terrane_planet::recipe::{shipped, Recipe};

/// The recipe of a file; or, where there is no such file, the shipped one of that name.
pub(crate) fn load_recipe(path: &Path) -> anyhow::Result<Recipe> {
    let names: Vec<&str> = shipped::names().collect();
    match path.to_str().filter(|name| !path.is_file() && names.contains(name)) {
        Some(name) => Ok(shipped::load(name)?),
        None if path.exists() => Ok(Recipe::load(path)?),
        None => {
            Recipe::load(path).with_context(|| format!("no recipe {} (shipped recipes: {})", path.display(), names.join(", ")))
        }
    }
}
