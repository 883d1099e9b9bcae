//! Where records come from: a planet file, or whatever else answers for one. A reader asks for as many bytes as it needs, and decodes them
//! the same way wherever they are from.

use super::error::{RecordError, StoreError};
use super::geometry::{self, Head};
use super::planet_file::PlanetFile;
use super::{imagery, maps, surroundings};
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::mesh::progressive::{MeshPrefix, PatchFacts};
use crate::mesh::wake::Wake;
use std::ops::Range;
use std::path::Path;

/// What there are records of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// A patch's mesh.
    Geometry,
    /// A patch's texture.
    Texture,
    /// The heights around a patch.
    Surroundings,
}

impl Part {
    /// What messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Part::Geometry => "geometry",
            Part::Texture => "texture",
            Part::Surroundings => "surroundings",
        }
    }
}

/// Where records come from. What is not there, or not any more, is `None`; of a cache it may go at any moment.
pub trait Records: Send {
    /// Where that is, for messages.
    fn path(&self) -> &Path;

    /// Grid cells a side of all patches.
    fn cells(&self) -> u32;

    /// What is known of a patch without its records.
    ///
    /// # Errors
    /// If it cannot be read, or is damaged.
    fn facts(&self, id: PatchId) -> Result<Option<PatchFacts>, StoreError>;

    /// Bytes of a record, as far as it has them; there may be more at their end than were asked for.
    ///
    /// # Errors
    /// If they cannot be read.
    fn bytes(&self, id: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError>;

    /// The record of the map of the planet's clouds.
    ///
    /// # Errors
    /// If it cannot be read.
    fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError>;

    /// How many bytes of a mesh are asked for first: its head, and in most cases the first chunk.
    fn first_bytes(&self) -> usize {
        4096
    }
}

impl Records for PlanetFile {
    fn path(&self) -> &Path {
        PlanetFile::path(self)
    }

    fn cells(&self) -> u32 {
        self.header().cells
    }

    fn facts(&self, id: PatchId) -> Result<Option<PatchFacts>, StoreError> {
        PlanetFile::facts(self, id)
    }

    fn bytes(&self, id: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError> {
        self.record_bytes(id, part, range)
    }

    fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError> {
        PlanetFile::cloud_record(self)
    }
}

/// The first chunks of a patch's mesh, up to the first after which what is left out is `enough` asleep: a condition on its largest wake.
/// No more of the record is read.
///
/// # Errors
/// If it cannot be read, or is damaged.
pub fn mesh(
    records: &dyn Records,
    id: PatchId,
    enough: &dyn Fn(&PatchFacts, Wake) -> bool,
) -> Result<Option<MeshPrefix>, StoreError> {
    let cells = records.cells();
    let Some(mut bytes) = records.bytes(id, Part::Geometry, 0..records.first_bytes())? else { return Ok(None) };
    let wrong = |reason| damaged(records, id, Part::Geometry, reason);
    let head = Head::read(&bytes, id, cells).map_err(wrong)?;
    let chunks = head.chunks_until(enough);
    let end = head.bytes_of(chunks);
    if end > bytes.len() {
        let Some(rest) = records.bytes(id, Part::Geometry, bytes.len()..end)? else { return Ok(None) };
        bytes.extend(rest);
    }
    geometry::decode_chunks(&head, &bytes, id, cells, chunks).map(Some).map_err(wrong)
}

/// A patch's texture.
///
/// # Errors
/// If it cannot be read, or is damaged.
pub fn texture(records: &dyn Records, id: PatchId) -> Result<Option<PatchTexture>, StoreError> {
    whole(records, id, Part::Texture, imagery::decode)
}

/// Heights around a patch, as [`sample_surroundings`](crate::ground::surroundings::sample_surroundings) gives them.
///
/// # Errors
/// If they cannot be read, or are damaged.
pub fn surroundings(records: &dyn Records, id: PatchId) -> Result<Option<Vec<i32>>, StoreError> {
    whole(records, id, Part::Surroundings, surroundings::decode)
}

/// The map of the planet's clouds of `side` texels a side.
///
/// # Errors
/// If it cannot be read, or is damaged.
pub fn cloud_map(records: &dyn Records, side: usize) -> Result<Option<Vec<u8>>, StoreError> {
    let decoded = records.cloud_record()?.map(|record| maps::decode(&record, side)).transpose();
    decoded
        .map_err(|source| StoreError::Damaged { file: records.path().to_owned(), what: format!("the map of clouds: {source}") })
}

fn whole<T>(
    records: &dyn Records,
    id: PatchId,
    part: Part,
    decode: impl Fn(&[u8], PatchId, u32) -> Result<T, RecordError>,
) -> Result<Option<T>, StoreError> {
    let bytes = records.bytes(id, part, 0..usize::MAX)?;
    let decoded = bytes.map(|bytes| decode(&bytes, id, records.cells())).transpose();
    decoded.map_err(|reason| damaged(records, id, part, reason))
}

fn damaged(records: &dyn Records, id: PatchId, part: Part, source: RecordError) -> StoreError {
    StoreError::DamagedPatch { file: records.path().to_owned(), id, part: part.name(), source }
}
