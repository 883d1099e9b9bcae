//! Writes a planet file as a folder of objects.

use super::directory::{layers, order, root_of, Directory, PatchEntry, Segment};
use super::manifest::{Manifest, NamedReference, Reference, LAYOUT_VERSION, MANIFEST};
use super::name::ObjectName;
use crate::globe::patch::PatchId;
use crate::mesh::certificate::{DEVIATION_SHARE, KAPPA};
use crate::store::geometry::Head;
use crate::store::record::RECORD_VERSION;
use crate::store::{Part, PatchRecord, PlanetFile, RecordError, Records, StoreError, FORMAT_VERSION};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Why a planet cannot be published.
#[derive(Debug, Error)]
pub enum PublishError {
    /// The planet file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The folder.
    #[error("{path}: cannot {action}: {source}")]
    System {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Another planet is there.
    #[error("{path}: {name} is published there; publish {other} into another folder, or remove that one")]
    Occupied {
        /// Its `planet.json`.
        path: PathBuf,
        /// Whose it is.
        name: String,
        /// The planet to publish.
        other: String,
    },
    /// It was told to stop.
    #[error("stopped; what was written stays, and the next run goes on from there")]
    Stopped,
}

/// What publishing did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Publishing {
    /// Patches whose mesh was published.
    pub patches: u64,
    /// Objects written.
    pub written: u64,
    /// Bytes of them.
    pub written_bytes: u64,
    /// Objects that were there already.
    pub kept: u64,
    /// Bytes of all objects that the planet has now.
    pub bytes: u64,
    /// Objects that nothing names any more, and that were removed.
    pub removed: u64,
}

/// Publishes all patches of a planet file in a folder: objects first, `planet.json` last, each of them whole or not at all. Objects that
/// are there stay; those that nothing names any more go only if `removes`, since readers may still be on their way to them.
///
/// # Errors
/// If the file cannot be read, the folder not be written, or another planet is there, and when `stop` is raised.
pub fn publish(
    file: &PlanetFile,
    folder: &Path,
    removes: bool,
    progress: &dyn Fn(usize, usize),
    stop: &AtomicBool,
) -> Result<Publishing, PublishError> {
    let header = file.header();
    check_folder(folder, &header.name)?;
    let index = file.index()?;
    let mut shards: BTreeMap<Root, Vec<PatchRecord>> = BTreeMap::new();
    for record in &index {
        // With all that lead to it, though nothing may be known there.
        let mut root = root_of(record.id);
        shards.entry(Root::of(root)).or_default().push(*record);
        while let Some(parent) = root.parent() {
            root = root_of(parent);
            shards.entry(Root::of(root)).or_default();
        }
    }
    for root in PatchId::roots() {
        shards.entry(Root::of(root)).or_default();
    }
    let mut writer = Writer { folder, done: Publishing::default(), names: HashSet::new() };
    let mut below: BTreeMap<Root, Vec<(PatchId, Reference)>> = BTreeMap::new();
    let (total, mut done, mut finest) = (index.len(), 0, 0);
    // Fine to coarse: a directory names those below it.
    for (key, records) in shards.iter().rev() {
        if stop.load(Ordering::Relaxed) {
            return Err(PublishError::Stopped);
        }
        let mut shards_below = below.remove(key).unwrap_or_default();
        shards_below.sort_by_key(|(root, _)| order(*root));
        let reference = writer.shard(file, key.id, records, shards_below)?;
        if let Some(parent) = key.id.parent() {
            below.entry(Root::of(root_of(parent))).or_default().push((key.id, reference));
        } else {
            below.entry(*key).or_default().push((key.id, reference));
        }
        let meshes = records.iter().filter(|record| record.has_mesh());
        finest = meshes.clone().map(|record| record.id.level).fold(finest, u8::max);
        writer.done.patches += meshes.count() as u64;
        done += records.len();
        progress(done, total);
    }
    let face = |k: usize| {
        let root = PatchId::roots().nth(k).map(Root::of);
        root.and_then(|root| below.get(&root)).map_or_else(|| Reference::to(&[]), |found| found[0].1)
    };
    let assets = header
        .assets
        .iter()
        .map(|asset| Ok(NamedReference { name: asset.name.clone(), reference: writer.object(&asset.bytes)? }));
    let assets = assets.collect::<Result<_, PublishError>>()?;
    let recipe = writer.object(header.recipe.as_bytes())?;
    let clouds = Records::cloud_record(file)?.map(|record| writer.object(&record)).transpose()?;
    let manifest = Manifest {
        terrane_layout: LAYOUT_VERSION,
        format: FORMAT_VERSION,
        record: RECORD_VERSION,
        name: header.name.clone(),
        cells: header.cells,
        lattice_unit_m: header.lattice.unit,
        lattice_radius: header.lattice.radius,
        height_range_m: header.height_range,
        builder: [KAPPA, DEVIATION_SHARE],
        recipe,
        assets,
        clouds,
        faces: std::array::from_fn(face),
        patches: writer.done.patches,
        bytes: writer.done.bytes,
        finest_level: finest,
    };
    put(&folder.join(MANIFEST), manifest.text().as_bytes())?;
    if removes {
        writer.done.removed = writer.remove_unnamed()?;
    }
    Ok(writer.done)
}

/// Shards by level, and then in any order that is always the same.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Root {
    order: (u8, u8, u32, u32),
    id: PatchId,
}

impl Root {
    fn of(id: PatchId) -> Root {
        Root { order: (id.level, id.face.index(), id.y, id.x), id }
    }
}

/// Refuses a folder that holds another planet.
fn check_folder(folder: &Path, name: &str) -> Result<(), PublishError> {
    let path = folder.join(MANIFEST);
    let Ok(bytes) = std::fs::read(&path) else { return Ok(()) };
    let there =
        serde_json::from_slice::<serde_json::Value>(&bytes).ok().and_then(|there| there["name"].as_str().map(str::to_owned));
    match there {
        Some(there) if there == name => Ok(()),
        there => {
            let (name, other) = (there.unwrap_or_else(|| "something else".to_owned()), name.to_owned());
            Err(PublishError::Occupied { path, name, other })
        }
    }
}

struct Writer<'a> {
    folder: &'a Path,
    done: Publishing,
    names: HashSet<ObjectName>,
}

impl Writer<'_> {
    /// Writes the data and the directory of a shard.
    fn shard(
        &mut self,
        file: &PlanetFile,
        root: PatchId,
        records: &[PatchRecord],
        below: Vec<(PatchId, Reference)>,
    ) -> Result<Reference, PublishError> {
        let mut bytes_of: HashMap<(PatchId, Part), Vec<u8>> = HashMap::new();
        let mut patches = Vec::with_capacity(records.len());
        for record in records {
            let id = record.id;
            let mut read = |part: Part| -> Result<Vec<Segment>, PublishError> {
                let Some(bytes) = file.bytes(id, part, 0..usize::MAX)? else { return Ok(Vec::new()) };
                let segments = segments(file, id, part, &bytes)?;
                bytes_of.insert((id, part), bytes);
                Ok(segments)
            };
            let geometry = read(Part::Geometry)?;
            let texture = read(Part::Texture)?.pop();
            patches.push(PatchEntry { id, facts: record.facts, geometry, texture });
        }
        let mut directory = Directory::new(root, patches, below);
        let mut data = Vec::with_capacity(directory.data_bytes as usize);
        let mut taken: HashMap<(PatchId, Part), usize> = HashMap::new();
        for (id, part, segment) in layers(&mut directory.patches) {
            let from = taken.entry((id, part)).or_default();
            let length = segment.length() as usize;
            data.extend_from_slice(&bytes_of[&(id, part)][*from..*from + length]);
            *from += length;
        }
        directory.data = ObjectName::of(&data);
        if !data.is_empty() {
            self.object(&data)?;
        }
        self.object(&directory.encode())
    }

    /// Writes an object, unless it is there.
    fn object(&mut self, bytes: &[u8]) -> Result<Reference, PublishError> {
        let reference = Reference::to(bytes);
        if !self.names.insert(reference.object) {
            return Ok(reference);
        }
        self.done.bytes += bytes.len() as u64;
        let path = self.folder.join(reference.object.path());
        // Written under another name first, so what is there under its own is whole.
        if std::fs::metadata(&path).is_ok_and(|there| there.len() == bytes.len() as u64) {
            self.done.kept += 1;
            return Ok(reference);
        }
        put(&path, bytes)?;
        self.done.written += 1;
        self.done.written_bytes += bytes.len() as u64;
        Ok(reference)
    }

    /// Removes objects that nothing names.
    fn remove_unnamed(&self) -> Result<u64, PublishError> {
        let objects = self.folder.join("objects");
        let failed = |path: &Path, source| PublishError::System { path: path.to_owned(), action: "look into the folder", source };
        let mut removed = 0;
        for folder in std::fs::read_dir(&objects).map_err(|e| failed(&objects, e))? {
            let folder = folder.map_err(|e| failed(&objects, e))?.path();
            for entry in std::fs::read_dir(&folder).map_err(|e| failed(&folder, e))? {
                let path = entry.map_err(|e| failed(&folder, e))?.path();
                let name = path.file_name().and_then(|name| name.to_str()).and_then(ObjectName::parse);
                let is_draft = path.extension().is_some_and(|extension| extension == "new");
                if is_draft || name.is_some_and(|name| !self.names.contains(&name)) {
                    let gone = std::fs::remove_file(&path);
                    gone.map_err(|source| PublishError::System { path, action: "remove an object of before", source })?;
                    removed += 1;
                }
            }
        }
        Ok(removed)
    }
}

/// The segments of a record.
fn segments(file: &PlanetFile, id: PatchId, part: Part, bytes: &[u8]) -> Result<Vec<Segment>, PublishError> {
    if part != Part::Geometry {
        return Ok(vec![Segment::of(bytes)]);
    }
    let wrong = |source: RecordError| StoreError::DamagedPatch { file: file.path().to_owned(), id, part: part.name(), source };
    let head = Head::read(bytes, id, file.header().cells).map_err(wrong)?;
    let mut from = 0;
    let mut segments = Vec::with_capacity(head.chunks.len());
    for chunk in &head.chunks {
        let short = || wrong(RecordError::Short { what: "record", found: bytes.len(), expected: chunk.bytes.end });
        segments.push(Segment::of(bytes.get(from..chunk.bytes.end).ok_or_else(short)?));
        from = chunk.bytes.end;
    }
    Ok(segments)
}

/// Writes a file beside its place and moves it there when it is complete.
fn put(path: &Path, bytes: &[u8]) -> Result<(), PublishError> {
    let system = |action| move |source| PublishError::System { path: path.to_owned(), action, source };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(system("make its folder"))?;
    }
    let mut draft = path.as_os_str().to_owned();
    draft.push(format!(".{}.new", std::process::id()));
    let draft = PathBuf::from(draft);
    let write = || -> std::io::Result<()> {
        let mut file = std::fs::File::create(&draft)?;
        file.write_all(bytes)?;
        file.sync_data()
    };
    let moved =
        write().map_err(system("write it")).and_then(|()| std::fs::rename(&draft, path).map_err(system("move it into place")));
    if moved.is_err() {
        // The first error is the one to report.
        let _ = std::fs::remove_file(&draft);
    }
    moved
}
