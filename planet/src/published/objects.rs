//! Where the files of a published planet lie.

use super::manifest::{MANIFEST, MOST_MANIFEST_BYTES};
use super::name::ObjectName;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why bytes did not come.
#[derive(Debug, Error)]
pub enum FetchError {
    /// They are not there, and will not be.
    #[error("{0}")]
    Missing(String),
    /// Not now: another time they may come.
    #[error("{0}")]
    Unreachable(String),
}

/// Whether bytes may come from something on the way that keeps them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Freshness {
    /// From wherever they come soonest.
    Any,
    /// From where they lie: those that came before were wrong.
    Origin,
}

/// Where the files of a published planet lie. Whoever asks checks what comes.
pub trait Objects: Send + Sync {
    /// Where that is, for messages.
    fn place(&self) -> &Path;

    /// The bytes of `planet.json`.
    ///
    /// # Errors
    /// If they do not come.
    fn manifest(&self) -> Result<Vec<u8>, FetchError>;

    /// Bytes of an object that were kept from before, if they were.
    fn kept(&self, _: ObjectName, _: &Range<u64>) -> Option<Vec<u8>> {
        None
    }

    /// Keeps bytes of an object, which are right, for another time.
    fn keep(&self, _: ObjectName, _: &Range<u64>, _: &[u8]) {}

    /// Bytes of an object from where it lies. There may be other bytes, or other numbers of them, than were asked for.
    ///
    /// # Errors
    /// If they do not come.
    fn read(&self, object: ObjectName, range: Range<u64>, from: Freshness) -> Result<Vec<u8>, FetchError>;

    /// Whether as much is on its way as can be: what is asked for now waits for that.
    fn is_busy(&self) -> bool {
        false
    }

    /// Requests that went over a network so far, and bytes that came by them.
    fn traffic(&self) -> (u64, u64) {
        (0, 0)
    }
}

/// A folder on this machine.
#[derive(Debug)]
pub struct FolderObjects {
    folder: PathBuf,
}

impl FolderObjects {
    /// The folder that holds a `planet.json`.
    pub fn new(folder: &Path) -> FolderObjects {
        FolderObjects { folder: folder.to_owned() }
    }

    fn read_at(&self, path: &str, range: Range<u64>) -> Result<Vec<u8>, FetchError> {
        let path = self.folder.join(path);
        let read = || {
            let mut file = File::open(&path)?;
            file.seek(SeekFrom::Start(range.start))?;
            let mut bytes = Vec::new();
            file.take(range.end.saturating_sub(range.start)).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        read().map_err(|error: std::io::Error| {
            let message = format!("cannot read {}: {error}", path.display());
            match error.kind() {
                std::io::ErrorKind::NotFound => FetchError::Missing(message),
                _ => FetchError::Unreachable(message),
            }
        })
    }
}

impl Objects for FolderObjects {
    fn place(&self) -> &Path {
        &self.folder
    }

    fn manifest(&self) -> Result<Vec<u8>, FetchError> {
        self.read_at(MANIFEST, 0..MOST_MANIFEST_BYTES)
    }

    fn read(&self, object: ObjectName, range: Range<u64>, _: Freshness) -> Result<Vec<u8>, FetchError> {
        self.read_at(&object.path(), range)
    }
}
