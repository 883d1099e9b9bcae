//! A planet as 3D Tiles 1.1, for other renderers: one GLB a patch and nested tilesets.
//!
//! In: the patches of a plan, from a planet file or built. Out: a folder that any static server can hand out. Clients draw tiles of any levels
//! side by side and know nothing of wakes. So a tile is a mesh of its own, as coarse as its error allows, and closes the gaps to its
//! neighbours with walls towards the planet's centre; how far it lies off the finest surface is measured, stated, and decides when clients
//! replace it. docs/tiles.md is for users, docs/design.md ("3D Tiles") says why it holds.
//!
//! Reading order: `certify` (what is promised), `grid` (what errors are measured against), `sheet` and `sea` (the triangles), `frame`
//! (their numbers), `content` (a GLB), `tileset` (the JSON), `folder` (the files), and [`check`], which reads them again.

mod bounds;
mod certify;
pub mod check;
mod content;
mod folder;
mod frame;
mod grid;
mod sea;
mod sheet;
mod tileset;

pub use certify::Promise;
pub use content::{Certified, PictureCodec, Source, TileMaker};
pub use folder::{Published, TILESET};
pub use tileset::MOST_PIXELS;

use crate::export::ExportError;
use crate::globe::patch::PatchId;
use crate::store::StoreError;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Why tiles cannot be made.
#[derive(Debug, Error)]
pub enum TilesError {
    /// The planet file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A GLB.
    #[error("tile {id}: {source}")]
    Export {
        /// The tile.
        id: PatchId,
        /// What is wrong.
        source: ExportError,
    },
    /// A size of maps that cannot be.
    #[error(transparent)]
    Maps(ExportError),
    /// A map that cannot be encoded.
    #[error("tile {id}: cannot encode a map as JPEG: {problem}; please report this")]
    Picture {
        /// The tile.
        id: PatchId,
        /// What its writer said.
        problem: String,
    },
    /// A file.
    #[error("cannot {what} {path}: {source}; make room or choose another folder, and start again: what is there is kept")]
    File {
        /// What was tried.
        what: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// How the maker of tiles is watched, and stopped.
pub struct Watch<'a> {
    /// Called on the calling thread with tiles done and to do.
    pub progress: &'a dyn Fn(usize, usize),
    /// Set to end soon; what is written is kept.
    pub stop: &'a AtomicBool,
}

impl Watch<'_> {
    /// Works through items on all processors, a few at a time; `None` if it was stopped.
    fn all<T: Sync, R: Send>(
        &self,
        items: &[T],
        work: impl Fn(&T) -> Result<R, TilesError> + Sync,
    ) -> Result<Option<Vec<R>>, TilesError> {
        use rayon::prelude::*;
        let mut done = Vec::with_capacity(items.len());
        for some in items.chunks(4 * rayon::current_num_threads()) {
            if self.stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let found: Result<Vec<R>, TilesError> = some.par_iter().map(&work).collect();
            done.extend(found?);
            (self.progress)(done.len(), items.len());
        }
        Ok(Some(done))
    }
}
