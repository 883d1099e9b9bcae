//! What the benchmarks share: the shipped planets, and the patches they are measured on.

use std::path::Path;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;

/// Grid cells along a patch side, as shipped.
const CELLS: u32 = 128;

/// Levels from a whole face (100 km cells on an Earth) to cells of 0.6 m.
#[allow(dead_code, reason = "not every benchmark goes through the levels")]
pub(crate) const LEVELS: [u8; 4] = [0, 5, 10, 17];

/// A shipped planet.
#[allow(dead_code, reason = "one benchmark chooses the grid")]
pub(crate) fn planet(name: &str) -> Planet {
    grid_of(name, CELLS)
}

/// A shipped planet with patches of so many cells a side.
pub(crate) fn grid_of(name: &str, cells: u32) -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recipes/{name}.toml"));
    let recipe = Recipe::load(&path).unwrap_or_else(|e| panic!("{e}"));
    Planet::from_recipe(recipe, cells).unwrap_or_else(|e| panic!("{e}"))
}

/// Patches of a level at sites named for what terra has there.
pub(crate) fn patches(level: u8) -> impl Iterator<Item = (&'static str, PatchId)> {
    let sites = [("coast", 36.62, 106.05), ("mountains", -20.0, -150.0), ("ocean", 20.0, 10.0)];
    sites.into_iter().map(move |(name, lat, lon)| (name, PatchId::containing(direction_at(lat, lon), level)))
}
