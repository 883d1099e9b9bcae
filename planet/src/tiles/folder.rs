//! The files of a set of tiles: `tileset.json`, and all else under names that are hashes of their bytes, in folders of two digits.
//!
//! A name never changes its bytes, so that what is there stays and caches may keep it for good. Files are written beside and moved into
//! place, `tileset.json` last; then what it does not lead to any more is removed.

use super::bounds::TileBox;
use super::content::{Certified, TileMaker};
use super::tileset::{Entry, Set};
use super::{TilesError, Watch};
use crate::globe::patch::PatchId;
use crate::published::ObjectName;
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::io::Write;
use std::path::Path;

/// The first file of a set.
pub const TILESET: &str = "tileset.json";

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Published {
    /// Tiles of the set.
    pub tiles: usize,
    /// Files written, files that were there, and files that were removed.
    pub written: usize,
    /// Files that were there before under the same names.
    pub kept: usize,
    /// Files of the set before that this one does not need.
    pub removed: usize,
    /// Bytes of all files of the set.
    pub bytes: u64,
    /// Bytes of the tiles alone.
    pub tile_bytes: u64,
    /// Triangles of all tiles, skirts included.
    pub triangles: u64,
    /// Largest radial error of a tile without children, in metres.
    pub finest_error: f64,
    /// The same of the six faces.
    pub coarsest_error: f64,
}

/// The name of bytes: folder, and file with an extension.
pub(super) fn name_of(bytes: &[u8], extension: &str) -> String {
    let digits = ObjectName::of(bytes).to_string();
    format!("{}/{digits}.{extension}", &digits[..2])
}

/// Whether a name below the folder is one that [`name_of`] gives.
pub(super) fn is_content_name(name: &str) -> bool {
    let Some((folder, file)) = name.split_once('/') else { return false };
    let Some((digits, extension)) = file.split_once('.') else { return false };
    ObjectName::parse(digits).is_some_and(|name| name.to_string()[..2] == *folder) && ["glb", "json"].contains(&extension)
}

fn failed<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(std::io::Error) -> TilesError + 'a {
    move |source| TilesError::File { what, path: path.to_owned(), source }
}

/// Writes a file beside and moves it into place.
fn write(path: &Path, bytes: &[u8]) -> Result<(), TilesError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed("make", folder))?;
    let part = path.with_extension("part");
    let written =
        std::fs::File::create(&part).and_then(|mut file| file.write_all(bytes)).and_then(|()| std::fs::rename(&part, path));
    written.map_err(|source| {
        let _ = std::fs::remove_file(&part);
        TilesError::File { what: "write", path: path.to_owned(), source }
    })
}

/// Writes bytes under their name, unless they are there. Out: the name, and whether it was written.
fn put(folder: &Path, bytes: &[u8], extension: &str) -> Result<(String, bool), TilesError> {
    let name = name_of(bytes, extension);
    let path = folder.join(&name);
    let is_there = std::fs::metadata(&path).is_ok_and(|there| there.is_file() && there.len() == bytes.len() as u64);
    if !is_there {
        write(&path, bytes)?;
    }
    Ok((name, !is_there))
}

/// What became of a tile.
struct Made {
    name: String,
    bounds: TileBox,
    bytes: u64,
    triangles: u64,
    written: bool,
}

impl TileMaker<'_> {
    /// Writes the tiles that were certified into a folder; `None` if it was stopped, with what is written kept.
    ///
    /// # Errors
    /// If something cannot be read or written.
    pub fn publish(&self, certified: &Certified, folder: &Path, watch: &Watch) -> Result<Option<Published>, TilesError> {
        let mut ids: Vec<PatchId> = certified.tiles.keys().copied().collect();
        // Parents first: their heights help their children's.
        ids.sort_unstable_by_key(|id| (id.level, id.face, id.y, id.x));
        let make = |&id: &PatchId| {
            let content = self.content(certified, id)?;
            let (name, written) = put(folder, &content.bytes, "glb")?;
            let (bytes, triangles) = (content.bytes.len() as u64, content.triangles as u64);
            Ok(Made { name, bounds: content.bounds, bytes, triangles, written })
        };
        let Some(made) = watch.all(&ids, make)? else { return Ok(None) };
        let mut done = Published { tiles: ids.len(), ..Published::default() };
        let mut needed = HashSet::new();
        for made in &made {
            needed.insert(made.name.clone()).then(|| done.count(made.bytes, made.written));
            done.triangles += made.triangles;
        }
        done.tile_bytes = done.bytes;
        let entries = self.entries(certified, &ids, made);
        let is_leaf = |id: PatchId| id.children().is_none_or(|children| !entries.contains_key(&children[0]));
        let worst = |of: &dyn Fn(PatchId) -> bool| {
            entries.iter().filter(|(id, _)| of(**id)).map(|(_, entry)| entry.promise.error).fold(0.0, f64::max)
        };
        (done.finest_error, done.coarsest_error) = (worst(&is_leaf), worst(&|id| id.level == 0));
        let set = Set { entries: &entries, radius: self.planet.recipe.radius, planet: &self.planet.recipe.name };
        let mut inner: HashMap<PatchId, String> = HashMap::new();
        for &id in ids.iter().rev().filter(|id| set.begins_file(**id)) {
            let bytes = set.nested(id, &inner, "../").to_string().into_bytes();
            let (name, written) = put(folder, &bytes, "json")?;
            needed.insert(name.clone()).then(|| done.count(bytes.len() as u64, written));
            inner.insert(id, name);
        }
        let root = root_bytes(&set.root(&inner));
        let path = folder.join(TILESET);
        let is_same = std::fs::read(&path).is_ok_and(|there| there == root);
        if !is_same {
            write(&path, &root)?;
        }
        done.count(root.len() as u64, !is_same);
        done.removed = sweep(folder, &needed)?;
        Ok(Some(done))
    }

    /// All tiles with boxes that hold those of their children.
    fn entries(&self, certified: &Certified, ids: &[PatchId], made: Vec<Made>) -> HashMap<PatchId, Entry> {
        let entry =
            |(id, made): (&PatchId, Made)| (*id, Entry { name: made.name, bounds: made.bounds, promise: certified.tiles[id].1 });
        let mut entries: HashMap<PatchId, Entry> = ids.iter().zip(made).map(entry).collect();
        for id in ids.iter().rev() {
            let corners = entries[id].bounds.corners();
            if let Some(parent) = id.parent().and_then(|parent| entries.get_mut(&parent)) {
                corners.into_iter().for_each(|corner| parent.bounds.include(corner));
            }
        }
        entries
    }
}

impl Published {
    fn count(&mut self, bytes: u64, written: bool) {
        self.bytes += bytes;
        *(if written { &mut self.written } else { &mut self.kept }) += 1;
    }
}

fn root_bytes(root: &Value) -> Vec<u8> {
    root.to_string().into_bytes()
}

/// Removes files of earlier sets, and what was cut off while it was written. Out: how many.
fn sweep(folder: &Path, needed: &HashSet<String>) -> Result<usize, TilesError> {
    let mut removed = 0;
    for sub in std::fs::read_dir(folder).map_err(failed("read", folder))?.flatten() {
        let (path, name) = (sub.path(), sub.file_name().to_string_lossy().into_owned());
        if name.len() != 2 || !path.is_dir() {
            continue;
        }
        for file in std::fs::read_dir(&path).map_err(failed("read", &path))?.flatten() {
            let (file, inner) = (file.path(), format!("{name}/{}", file.file_name().to_string_lossy()));
            let as_content = inner.strip_suffix(".part").map_or(inner.clone(), |stem| format!("{stem}.glb"));
            if is_content_name(&as_content) && !needed.contains(&inner) {
                std::fs::remove_file(&file).map_err(failed("remove", &file))?;
                removed += 1;
            }
        }
        // Fails where something is left in it, which is as it should be.
        let _ = std::fs::remove_dir(&path);
    }
    Ok(removed)
}
