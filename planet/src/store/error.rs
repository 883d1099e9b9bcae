//! What can be wrong with a planet file or with one of its records.

use crate::globe::patch::PatchId;
use rusqlite::ErrorCode;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What is wrong with the bytes of one patch record.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RecordError {
    /// Too short for what it has to hold.
    #[error("{what} ends after {found} bytes, expected {expected}")]
    Short {
        /// Part of the record.
        what: &'static str,
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        expected: usize,
    },
    /// Not a record of this kind.
    #[error("magic {found:?}, expected {expected:?}")]
    Magic {
        /// First four bytes.
        found: [u8; 4],
        /// What they should be.
        expected: [u8; 4],
    },
    /// A record of another version of the format.
    #[error("record version {found}, expected {expected}")]
    Version {
        /// Version of the record.
        found: u16,
        /// The version that this program reads.
        expected: u16,
    },
    /// The bytes are not those that were written.
    #[error("checksum {found:08x}, expected {expected:08x}")]
    Checksum {
        /// Checksum of the bytes.
        found: u32,
        /// Checksum that the record states.
        expected: u32,
    },
    /// A record of another patch, or of another grid.
    #[error("belongs to {found}, expected {expected}")]
    Belongs {
        /// Patch and cells of the record.
        found: String,
        /// Patch and cells that were asked for.
        expected: String,
    },
    /// A stream does not decompress to the length it must have.
    #[error("stream '{stream}' is damaged: {reason}")]
    Stream {
        /// Name of the stream.
        stream: &'static str,
        /// What went wrong.
        reason: String,
    },
    /// Bytes after the last stream.
    #[error("{0} bytes too many")]
    Trailing(usize),
    /// A vertex that no builder makes.
    #[error("vertex {index}: {reason}")]
    Vertex {
        /// Vertex index.
        index: usize,
        /// Which rule it breaks.
        reason: &'static str,
    },
    /// A part of a geometry record that can be read without those that follow.
    #[error("chunk {number} of {of}: {reason}")]
    Chunk {
        /// Which, counted from 1.
        number: usize,
        /// How many there are.
        of: usize,
        /// What is wrong with it.
        reason: Box<RecordError>,
    },
    /// Bounds, heights or measures that no builder makes.
    #[error("{0}")]
    Measure(&'static str),
}

/// Why a planet file cannot be used.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The system refused.
    #[error("{file}: cannot {action}: {source}")]
    System {
        /// The planet file.
        file: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The database refused.
    #[error("{file}: cannot {action}: {source}")]
    Database {
        /// The planet file.
        file: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// Some other file.
    #[error("{file}: not a planet file: found {found}, expected a database written by 'terrane bake'; choose another path")]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What it is.
        found: String,
    },
    /// A planet file of another format version.
    #[error("{file}: planet file of format version {found}, expected {expected}; {advice}")]
    Version {
        /// The planet file.
        file: PathBuf,
        /// Its version.
        found: u32,
        /// The version that this program reads.
        expected: u32,
        /// What to do next.
        advice: &'static str,
    },
    /// A planet file of another planet or grid than the one to be baked.
    #[error("{file}: holds another planet: {what} is {found}, expected {expected}; bake into another file or delete this one")]
    Differs {
        /// The planet file.
        file: PathBuf,
        /// What differs.
        what: &'static str,
        /// In the file.
        found: String,
        /// In the planet at hand.
        expected: String,
    },
    /// A planet file whose ground was edited since it was baked from the recipe at hand.
    #[error(
        "{file}: its ground was edited, so the recipe alone no longer describes it; to bake more of the edited planet name the file \
         itself as the recipe, or undo the edits"
    )]
    Edited {
        /// The planet file.
        file: PathBuf,
    },
    /// A planet file whose ground was edited, or an edit undone, since it was opened.
    #[error("{file}: its ground was edited since it was opened; open it again")]
    Changed {
        /// The planet file.
        file: PathBuf,
    },
    /// The file as a whole is damaged or cut short.
    #[error("{file}: damaged: {what}; delete it and bake it again")]
    Damaged {
        /// The planet file.
        file: PathBuf,
        /// What was found, and what was expected.
        what: String,
    },
    /// One patch is damaged.
    #[error("{file}: patch {id}: damaged {part}: {source}; delete the file and bake it again")]
    DamagedPatch {
        /// The planet file.
        file: PathBuf,
        /// The patch.
        id: PatchId,
        /// "geometry" or "texture".
        part: &'static str,
        /// What is wrong.
        source: RecordError,
    },
    /// A patch, or a part of it, that the file does not hold.
    #[error("{file}: patch {id} is not in the file; bake deeper levels, or build it from the recipe")]
    Absent {
        /// The planet file.
        file: PathBuf,
        /// The patch.
        id: PatchId,
    },
    /// Something of a published planet that cannot be had.
    #[error("{file}: cannot fetch {what}: {reason}")]
    Remote {
        /// Where the planet is published.
        file: PathBuf,
        /// What was asked for.
        what: String,
        /// Why it did not come, or what came instead.
        reason: String,
    },
    /// Writing to a file that was opened for reading.
    #[error("{file}: opened for reading only; open it with create_or_resume or open_to_edit to change it")]
    ReadOnly {
        /// The planet file.
        file: PathBuf,
    },
}

/// Sorts SQLite's errors: those that damage explains, and those of the system around the file.
pub(super) fn failure(path: &Path, action: &'static str, source: rusqlite::Error) -> StoreError {
    use rusqlite::ffi::SQLITE_IOERR_SHORT_READ;
    let damage = match &source {
        rusqlite::Error::SqliteFailure(error, _) => {
            let damaged = matches!(
                error.code,
                ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase | ErrorCode::Unknown | ErrorCode::TooBig
            );
            damaged || error.extended_code == SQLITE_IOERR_SHORT_READ
        }
        rusqlite::Error::SqlInputError { .. } | rusqlite::Error::QueryReturnedNoRows => true,
        rusqlite::Error::InvalidColumnType(..)
        | rusqlite::Error::IntegralValueOutOfRange(..)
        | rusqlite::Error::Utf8Error(..) => true,
        rusqlite::Error::FromSqlConversionFailure(..) => true,
        _ => false,
    };
    if damage {
        StoreError::Damaged { file: path.to_owned(), what: format!("cannot {action}: {source}") }
    } else {
        StoreError::Database { file: path.to_owned(), action, source }
    }
}
