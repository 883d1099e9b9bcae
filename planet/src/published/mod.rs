//! A planet file laid out for any static host: few kinds of files, of which all but one never change, and byte ranges that a reader can
//! ask for, check and decode one by one. No program has to run where they lie.
//!
//! ```text
//! planet.json                 what the planet is, and the names of the six faces' directories: the only file that is ever replaced
//! objects/3f/3f9c…            everything else, under the first bytes of its SHA-256 in hexadecimal
//! ```
//!
//! A *shard* is three levels of a quadtree: a patch, its children and theirs. Its *directory* holds what is known of these patches, the
//! length and the checksum of each *segment* of their records, and the directories of the shards below. Its *data* are the segments, layer
//! by layer: all first chunks of meshes, then textures, then the finer chunks. So one range brings a
//! region's base, and the next what refines it. Names are checksums, and directories name what is below them: who trusts `planet.json`
//! can check every byte that follows. A change of the ground changes the data of the shards that it touches, and directories from there
//! up.
//!
//! In: a planet file. Out: the folder ([`publish`]); and of a folder, wherever it is ([`Objects`]), records ([`PublishedRecords`]).

mod directory;
mod manifest;
mod name;
mod objects;
mod published_planet;
mod publishing;

pub use directory::{Directory, PatchEntry, Segment};
pub use manifest::{Manifest, ManifestError, NamedReference, Reference, LAYOUT_VERSION, MANIFEST, MOST_MANIFEST_BYTES};
pub use name::ObjectName;
pub use objects::{FetchError, FolderObjects, Freshness, Objects};
pub use published_planet::{Fetched, Otherwise, PublishedPlanet, PublishedRecords};
pub use publishing::{publish, PublishError, Publishing};
