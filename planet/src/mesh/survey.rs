//! A patch that was sampled and not built: what is known of it, and what is needed to build and to texture it.
//!
//! Whether a view draws a patch or its children follows from its samples, and so do its textures. The collapses, most of the work, are for
//! patches that are drawn.

use super::builder::Faults;
use super::progressive::patch_mesh::facts;
use super::progressive::{PatchFacts, PatchMesh};
use super::surface::Surface;
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::ground::{Ground, GroundColour, HeightGrid};

/// A sampled patch.
pub struct Survey {
    /// What is known of it.
    pub facts: PatchFacts,
    /// Its samples, and which patch it is.
    pub grid: HeightGrid,
    surface: Surface,
}

impl Survey {
    /// Samples a patch. A pure function of terrain and patch id.
    pub fn new(ground: &Ground, id: PatchId) -> Survey {
        let _span = tracing::debug_span!("survey", patch = %id).entered();
        let grid = HeightGrid::sample(ground, id);
        let surface = Surface::new(ground, &grid);
        Survey { facts: facts(ground, &grid, &surface), grid, surface }
    }

    /// Builds its mesh.
    pub fn mesh(&self, ground: &Ground) -> (PatchMesh, Faults) {
        let _span = tracing::debug_span!("build mesh", patch = %self.grid.id).entered();
        PatchMesh::of_surface(ground, &self.grid, &self.surface, self.facts)
    }

    /// Its textures.
    pub fn texture(&self, ground: &Ground, colour: &dyn GroundColour) -> PatchTexture {
        let _span = tracing::debug_span!("build texture", patch = %self.grid.id).entered();
        PatchTexture::new(ground, colour, self.grid.id, &self.grid)
    }
}
