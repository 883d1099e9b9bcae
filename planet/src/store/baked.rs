//! A patch on its way into a planet file, and what the file's index holds of it.
//!
//! A patch may lack its mesh, its texture, or both: what was surveyed, and what of it was built. A part of no bytes is one that is not there.

use super::error::RecordError;
use super::{facts, geometry, imagery};
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
    /// Number of vertices that never collapse; 0 without a mesh.
    pub always_awake: u32,
    /// Size of the geometry record; 0 if there is none.
    pub geometry_bytes: u32,
    /// Size of the texture record; 0 if there is none.
    pub texture_bytes: u32,
}

impl PatchRecord {
    /// Whether its mesh is stored.
    pub fn has_mesh(&self) -> bool {
        self.geometry_bytes > 0
    }

    /// Whether its texture is stored.
    pub fn has_texture(&self) -> bool {
        self.texture_bytes > 0
    }

    /// Whether both are.
    pub fn is_whole(&self) -> bool {
        self.has_mesh() && self.has_texture()
    }
}

/// A patch as it goes into the file.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedPatch {
    /// What the index holds of it.
    pub record: PatchRecord,
    /// Geometry record; empty without a mesh.
    pub geometry: Vec<u8>,
    /// Texture record; empty without a texture.
    pub texture: Vec<u8>,
}

impl BakedPatch {
    /// Encodes a patch. A pure function; the costly part of storing, so it runs on the builder's threads.
    ///
    /// # Errors
    /// For a mesh or texture that breaks the builder's promises.
    pub fn new(mesh: &PatchMesh, texture: &PatchTexture) -> Result<BakedPatch, RecordError> {
        BakedPatch::in_part(mesh.id, &mesh.facts, mesh.cells, Some(mesh), Some(texture))
    }

    /// Encodes what there is of a patch of `cells` cells a side.
    ///
    /// # Errors
    /// For facts, a mesh or a texture that break the builder's promises.
    pub fn in_part(
        id: PatchId,
        facts: &PatchFacts,
        cells: u32,
        mesh: Option<&PatchMesh>,
        texture: Option<&PatchTexture>,
    ) -> Result<BakedPatch, RecordError> {
        facts::check(facts).map_err(RecordError::Measure)?;
        let geometry = mesh.map_or(Ok(Vec::new()), geometry::encode)?;
        let texture = texture.map_or(Ok(Vec::new()), |texture| imagery::encode(texture, id, cells))?;
        let record = PatchRecord {
            id,
            facts: *facts,
            always_awake: mesh.map_or(0, |mesh| mesh.always_awake() as u32),
            geometry_bytes: geometry.len() as u32,
            texture_bytes: texture.len() as u32,
        };
        Ok(BakedPatch { record, geometry, texture })
    }
}
