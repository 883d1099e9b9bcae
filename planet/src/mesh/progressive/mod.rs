//! The progressive mesh of a patch: vertices in wake order, any prefix of which is a mesh.

pub mod index_levels;
pub mod mesh_prefix;
pub mod patch_facts;
pub mod patch_mesh;
pub mod replay;

pub use index_levels::{IndexLevel, IndexLevels};
pub use mesh_prefix::MeshPrefix;
pub use patch_facts::{PatchFacts, Quarter};
pub use patch_mesh::{PatchMesh, Vertex};
