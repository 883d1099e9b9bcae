//! Everything of one patch.

use super::builder::Faults;
use super::progressive::PatchMesh;
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::ground::{Ground, GroundColour, HeightGrid};

/// Samples, builds and textures one patch.
pub fn build_patch(ground: &Ground, colour: &dyn GroundColour, id: PatchId) -> (PatchMesh, PatchTexture, Faults) {
    let grid = HeightGrid::sample(ground, id);
    let (mesh, faults) = PatchMesh::build(ground, id, &grid);
    let texture = PatchTexture::new(ground, colour, id, &grid);
    (mesh, texture, faults)
}
