//! The planet file: one SQLite database that holds a recipe and the patches built from it.
//!
//! In: built patches, and what was surveyed of others. Out: the same, bit for bit, or a typed error that names the file and the patch.
//! Patches travel as self-contained records ([`record`]): versioned, checksummed, one compressed stream a field ([`geometry`],
//! [`imagery`]). Readers that need not know where these come from ask [`Records`].

mod baked;
mod cached;
mod error;
pub(crate) mod facts;
pub mod geometry;
mod header;
pub mod imagery;
mod maps;
mod pending;
mod planet_file;
mod predict;
pub mod record;
pub mod records;
mod region;
mod rows;
mod schema;
pub mod slow;
pub mod surroundings;

pub use baked::{BakedPatch, PatchRecord};
pub use error::{RecordError, StoreError};
pub use header::PlanetHeader;
pub use planet_file::PlanetFile;
pub use records::{Part, Records};
pub use region::Region;
pub use schema::{is_planet_file, APPLICATION_ID, FORMAT_VERSION};
