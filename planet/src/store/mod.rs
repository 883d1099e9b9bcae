//! The planet file: one SQLite database that holds a recipe and the patches built from it (DESIGN section 8).
//!
//! In: built patches. Out: the same patches, bit for bit, or a typed error that names the file and the patch. Patches travel as
//! self-contained records ([`record`]): versioned, checksummed, one compressed stream a field ([`geometry`], [`imagery`]).

pub mod error;
pub mod geometry;
pub mod imagery;
pub mod planet_file;
pub mod predict;
pub mod record;
mod rows;
mod schema;

pub use error::{RecordError, StoreError};
pub use planet_file::{BakedPatch, PatchRecord, PlanetFile, PlanetHeader};
pub use schema::{APPLICATION_ID, FORMAT_VERSION};
