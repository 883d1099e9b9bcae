//! Everything of one patch.

use super::builder::Faults;
use super::progressive::PatchMesh;
use super::survey::Survey;
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::ground::{Ground, GroundColour};

/// Samples, builds and textures one patch.
pub fn build_patch(ground: &Ground, colour: &dyn GroundColour, id: PatchId) -> (PatchMesh, PatchTexture, Faults) {
    let survey = Survey::new(ground, id);
    let (mesh, faults) = survey.mesh(ground);
    (mesh, survey.texture(ground, colour), faults)
}
