//! A patch on its way into a planet file, and what the file's index holds of it.

use super::error::RecordError;
use super::{geometry, imagery};
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::mesh::progressive::{PatchFacts, PatchMesh};

/// What is known of a stored patch without reading it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchRecord {
    /// Which patch.
    pub id: PatchId,
    /// What its mesh says of itself.
    pub facts: PatchFacts,
    /// Number of vertices that never collapse.
    pub always_awake: u32,
    /// Size of the geometry record.
    pub geometry_bytes: u32,
    /// Size of the texture record.
    pub texture_bytes: u32,
}

/// A patch as it goes into the file.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedPatch {
    /// What the index holds of it.
    pub record: PatchRecord,
    /// Geometry record.
    pub geometry: Vec<u8>,
    /// Texture record.
    pub texture: Vec<u8>,
}

impl BakedPatch {
    /// Encodes a patch. A pure function; the costly part of storing, so it runs on the builder's threads.
    ///
    /// # Errors
    /// For a mesh or texture that breaks the builder's promises.
    pub fn new(mesh: &PatchMesh, texture: &PatchTexture) -> Result<BakedPatch, RecordError> {
        let geometry = geometry::encode(mesh)?;
        let texture = imagery::encode(texture, mesh.id, mesh.cells)?;
        let record = PatchRecord {
            id: mesh.id,
            facts: mesh.facts,
            always_awake: mesh.always_awake() as u32,
            geometry_bytes: geometry.len() as u32,
            texture_bytes: texture.len() as u32,
        };
        Ok(BakedPatch { record, geometry, texture })
    }
}
