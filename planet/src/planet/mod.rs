//! A planet: recipe, terrain, lattice and grid together, from which every patch follows.

pub mod bake;
mod camera;
pub mod edits;
mod journeys;

pub use camera::{CLEARANCE_M, LEAST_ALTITUDE_M};
pub use journeys::Journey;

use crate::draw::tree::PatchTree;
use crate::globe::lattice::Lattice;
use crate::globe::patch::{PatchId, MAX_CELLS, MAX_LEVEL, MIN_CELLS};
use crate::ground::texture::PatchTexture;
use crate::ground::{Elevation, Ground, GroundColour, GroundPoint, KeptHeights};
use crate::maps::clouds::{cloud_map, CloudLevel, CLOUD_SIDE};
use crate::mesh::build_patch;
use crate::mesh::builder::Faults;
use crate::mesh::progressive::{PatchFacts, PatchMesh};
use crate::mesh::survey::Survey;
use crate::recipe::{Edit, Recipe, RecipeError};
use crate::store::{records, PlanetHeader, Records};
use crate::terrain::Terrain;
use glam::DVec3;
use thiserror::Error;

impl Elevation for Terrain {
    fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        Terrain::heights(self, directions, heights);
    }
}

impl GroundColour for Terrain {
    fn albedo(&self, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        Terrain::albedo(self, points, albedo);
    }

    fn above_sea(&self, points: &[GroundPoint]) -> Option<Vec<f64>> {
        Terrain::above_sea(self, points)
    }
}

/// Why a planet cannot be made.
#[derive(Debug, Error)]
pub enum PlanetError {
    /// The recipe.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// A grid that no patch has.
    #[error("{found} cells along a patch side, expected a power of two from {MIN_CELLS} to {MAX_CELLS}")]
    Cells {
        /// Cells asked for.
        found: u32,
    },
    /// An edit that raises or lowers the ground past what can be told apart.
    #[error(
        "edit {number} ({edit}): the ground there may lie between {} m and {} m, expected within {} m and {} m of the datum; \
         make it less deep or high", range.0.round(), range.1.round(), limits.0.ceil(), limits.1.floor()
    )]
    EditTooHigh {
        /// Number among the edits, from 1.
        number: usize,
        /// The edit.
        edit: Edit,
        /// Bounds of the heights there, in metres.
        range: (f64, f64),
        /// What the planet has room for.
        limits: (f64, f64),
    },
    /// A planet file whose lattice is not that of its recipe.
    #[error("'{name}': the file's lattice has unit {found} m, expected {expected} m from its recipe; bake it again")]
    Lattice {
        /// Name of the planet.
        name: String,
        /// Unit in the file, in metres.
        found: f64,
        /// Unit of the recipe, in metres.
        expected: f64,
    },
}

/// Lowest that an edit may dig, as a share of the planet's radius.
const DEEPEST_EDIT: f64 = 0.5;

/// Refuses edits that leave the lattice, which they must not change.
fn check_edits(recipe: &Recipe, terrain: &Terrain, lattice: &Lattice) -> Result<(), PlanetError> {
    let limits = (-DEEPEST_EDIT * recipe.radius, lattice.highest());
    let leaves = |range: &(f64, f64)| range.0 < limits.0 || range.1 > limits.1;
    match terrain.edits_range().iter().position(leaves) {
        None => Ok(()),
        Some(i) => {
            Err(PlanetError::EditTooHigh { number: i + 1, edit: recipe.edits[i], range: terrain.edits_range()[i], limits })
        }
    }
}

/// A planet, ready to build patches of.
pub struct Planet {
    /// What decides it.
    pub recipe: Recipe,
    /// Its ground.
    pub terrain: Terrain,
    /// Its lattice.
    pub lattice: Lattice,
    /// Grid cells along a patch side.
    pub cells: u32,
    /// Heights of the patches sampled last.
    kept: KeptHeights,
}

impl Planet {
    /// The planet of a recipe, with patches of `cells` cells a side.
    ///
    /// # Errors
    /// If the cells are not a power of two in range, or if one of the recipe's images is damaged.
    pub fn from_recipe(recipe: Recipe, cells: u32) -> Result<Planet, PlanetError> {
        if !cells.is_power_of_two() || !(MIN_CELLS..=MAX_CELLS).contains(&cells) {
            return Err(PlanetError::Cells { found: cells });
        }
        let terrain = Terrain::new(&recipe)?;
        Planet::of_terrain(recipe, terrain, cells)
    }

    /// The planet of a recipe that differs from this planet's by its edits alone. What was prepared for the rest is shared.
    fn edited(&self, recipe: Recipe) -> Result<Planet, PlanetError> {
        let terrain = self.terrain.with_edits(&recipe.edits);
        Planet::of_terrain(recipe, terrain, self.cells)
    }

    fn of_terrain(recipe: Recipe, terrain: Terrain, cells: u32) -> Result<Planet, PlanetError> {
        let lattice = Lattice::new(recipe.radius, terrain.layers_range().1);
        check_edits(&recipe, &terrain, &lattice)?;
        Ok(Planet { recipe, terrain, lattice, cells, kept: KeptHeights::new(cells) })
    }

    /// The planet that a planet file was baked from.
    ///
    /// # Errors
    /// If its recipe is not valid, or gives another lattice.
    pub fn from_header(header: &PlanetHeader) -> Result<Planet, PlanetError> {
        let recipe = Recipe::from_parts(&header.recipe, &header.name, header.assets.clone())?;
        let planet = Planet::from_recipe(recipe, header.cells)?;
        if planet.lattice != header.lattice {
            let (found, expected) = (header.lattice.unit, planet.lattice.unit);
            return Err(PlanetError::Lattice { name: header.name.clone(), found, expected });
        }
        Ok(planet)
    }

    /// What a planet file says about this planet.
    pub fn header(&self) -> PlanetHeader {
        let (lowest, highest) = self.terrain.height_range();
        PlanetHeader {
            name: self.recipe.name.clone(),
            recipe: self.recipe.text.clone(),
            assets: self.recipe.assets.clone(),
            cells: self.cells,
            lattice: self.lattice,
            height_range: [lowest, highest],
        }
    }

    /// The coarsest level whose samples stand at most so many metres apart on average, or the finest there is.
    pub fn level_of_spacing(&self, metres: f64) -> u8 {
        let spacing = |level: u8| self.lattice.sample_spacing(self.cells, level) * self.lattice.unit;
        (0..MAX_LEVEL).find(|&level| spacing(level) <= metres).unwrap_or(MAX_LEVEL)
    }

    /// What is known of this planet's patches.
    pub fn tree(&self, facts: impl IntoIterator<Item = (PatchId, PatchFacts)>) -> PatchTree {
        let dry = self.terrain.lowest_dry().unwrap_or(f64::MAX);
        let uppermost = self.recipe.sea.as_ref().map_or(f64::MIN, |sea| sea.level_m.min(dry));
        let lowest = uppermost.max(self.terrain.height_range().0);
        let tree = PatchTree::new(self.lattice, self.cells, lowest / self.lattice.unit, facts);
        match self.terrain.sea_level() {
            Some(level) => tree.with_sea(level, dry),
            None => tree,
        }
    }

    /// Distance from the planet's centre, in lattice units, within which there is no ground.
    pub fn ground_radius(&self) -> f64 {
        (self.recipe.radius + self.terrain.height_range().0) / self.lattice.unit - 2.0
    }

    /// Terrain on the lattice.
    pub fn ground(&self) -> Ground<'_> {
        Ground { elevation: &self.terrain, lattice: self.lattice, cells: self.cells, kept: Some(&self.kept) }
    }

    /// Samples a patch: what is known of it before it is built.
    pub fn survey(&self, id: PatchId) -> Survey {
        Survey::new(&self.ground(), id)
    }

    /// The map of the planet's clouds, if it has any, from the first of some files that holds it, or computed. Whether it was.
    pub fn clouds<'a>(&self, files: impl IntoIterator<Item = &'a dyn Records>) -> Option<(CloudLevel, bool)> {
        let clouds = self.recipe.clouds.as_ref()?;
        for file in files {
            match records::cloud_map(file, CLOUD_SIDE) {
                Ok(Some(map)) => return Some((map, false)),
                Ok(None) => {}
                Err(error) => tracing::warn!(%error, "the map of clouds is computed again"),
            }
        }
        Some((cloud_map(&self.recipe, clouds, CLOUD_SIDE), true))
    }

    /// Builds a patch: the same bytes as in any planet file of this recipe and grid.
    pub fn build(&self, id: PatchId) -> (PatchMesh, PatchTexture, Faults) {
        build_patch(&self.ground(), &self.terrain, id)
    }
}
