//! The directory of a shard: what is known of its patches, and where the segments of their records lie in its data.
//!
//! Its bytes are one zstd frame over little-endian numbers: magic 4, version 2, root (face 1, level 1, x 4, y 4), data (length 8, name 16),
//! number of patches 2 and of shards below 2; of each patch its id 9, facts, how many segments its mesh has 1 and its texture 1, and of each
//! segment length 4 and checksum 8; of each shard below its root 9, length 4 and name 16.

use super::manifest::Reference;
use super::name::ObjectName;
use crate::globe::patch::PatchId;
use crate::globe::sphere::Face;
use crate::mesh::progressive::PatchFacts;
use crate::store::record::RecordReader;
use crate::store::{facts, Part, RecordError};
use sha2::{Digest, Sha256};
use std::ops::Range;

const MAGIC: [u8; 4] = *b"TRSD";
const VERSION: u16 = 1;

/// Levels of a shard.
pub(super) const LEVELS: u8 = 3;

/// Most bytes of a directory before compression: that of a full shard takes less than half.
const MOST_RAW: usize = 1 << 14;

/// Most chunks of a mesh.
const MOST_CHUNKS: usize = 8;

/// Most bytes of a segment: a texture of the largest grid takes a tenth.
const MOST_SEGMENT: u32 = 1 << 22;

/// Compression level. The bytes of directories decide names, so it is fixed.
const ZSTD_LEVEL: i32 = 9;

/// Bytes of a segment's checksum: the first of its SHA-256.
pub(super) const SEGMENT_HASH_BYTES: usize = 8;

/// A stretch of a record: it is fetched and checked as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where it is in the shard's data.
    pub data: Range<u64>,
    /// The first bytes of its SHA-256.
    hash: [u8; SEGMENT_HASH_BYTES],
}

impl Segment {
    /// A segment of these bytes whose place is not known yet.
    pub(super) fn of(bytes: &[u8]) -> Segment {
        Segment { data: 0..bytes.len() as u64, hash: hash(bytes) }
    }

    /// Its bytes' number.
    pub(super) fn length(&self) -> u64 {
        self.data.end - self.data.start
    }

    /// Whether these are its bytes.
    pub fn holds(&self, bytes: &[u8]) -> bool {
        bytes.len() as u64 == self.length() && hash(bytes) == self.hash
    }
}

fn hash(bytes: &[u8]) -> [u8; SEGMENT_HASH_BYTES] {
    let digest: [u8; 32] = Sha256::digest(bytes).into();
    let mut first = [0; SEGMENT_HASH_BYTES];
    first.copy_from_slice(&digest[..SEGMENT_HASH_BYTES]);
    first
}

/// What a directory says of a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchEntry {
    /// Which patch.
    pub id: PatchId,
    /// What is known of it.
    pub facts: PatchFacts,
    /// Its mesh: the head with the first chunk, then one chunk each. Empty if it is not there.
    pub geometry: Vec<Segment>,
    /// Its texture, if it is there.
    pub texture: Option<Segment>,
}

impl PatchEntry {
    /// The segments of a part, in the order of its record; of what is not published none.
    pub fn segments(&self, part: Part) -> &[Segment] {
        match part {
            Part::Geometry => &self.geometry,
            Part::Texture => self.texture.as_slice(),
            Part::Surroundings => &[],
        }
    }
}

/// What is known of a shard.
#[derive(Clone, Debug, PartialEq)]
pub struct Directory {
    /// Its coarsest patch, whether that is there or not.
    pub root: PatchId,
    /// Its patches, coarse to fine, by row and column.
    pub patches: Vec<PatchEntry>,
    /// The shards below it, by their roots.
    pub below: Vec<(PatchId, Reference)>,
    /// The object with its data.
    pub data: ObjectName,
    /// Bytes of that.
    pub data_bytes: u64,
}

/// The root of the shard that a patch belongs to.
pub(super) fn root_of(id: PatchId) -> PatchId {
    id.ancestor(id.level - id.level % LEVELS)
}

/// Order of patches within a directory.
pub(super) fn order(id: PatchId) -> (u8, u32, u32) {
    (id.level, id.y, id.x)
}

/// Goes through the segments of patches in the order of their data.
pub(super) fn layers(patches: &mut [PatchEntry]) -> impl Iterator<Item = (PatchId, Part, &mut Segment)> {
    let mut all: Vec<(usize, (PatchId, Part, &mut Segment))> = Vec::new();
    for patch in patches {
        let id = patch.id;
        for (k, segment) in patch.geometry.iter_mut().enumerate() {
            all.push((if k == 0 { 0 } else { k + 1 }, (id, Part::Geometry, segment)));
        }
        all.extend(patch.texture.iter_mut().map(|segment| (1, (id, Part::Texture, segment))));
    }
    // Stable: within a layer patches stay coarse to fine.
    all.sort_by_key(|(layer, _)| *layer);
    all.into_iter().map(|(_, segment)| segment)
}

/// Puts the segments of patches one behind the other. Returns where they end.
fn lay_out(patches: &mut [PatchEntry]) -> Option<u64> {
    let mut at = 0u64;
    for (_, _, segment) in layers(patches) {
        let end = at.checked_add(segment.length())?;
        segment.data = at..end;
        at = end;
    }
    Some(at)
}

impl Directory {
    /// The directory of patches and of the shards below, without its data's name.
    pub(super) fn new(root: PatchId, mut patches: Vec<PatchEntry>, below: Vec<(PatchId, Reference)>) -> Directory {
        patches.sort_by_key(|patch| order(patch.id));
        let data_bytes = lay_out(&mut patches).unwrap_or(u64::MAX);
        Directory { root, patches, below, data: ObjectName::of(&[]), data_bytes }
    }

    /// What it says of a patch.
    pub fn patch(&self, id: PatchId) -> Option<&PatchEntry> {
        let found = self.patches.binary_search_by_key(&order(id), |patch| order(patch.id)).ok()?;
        self.patches.get(found).filter(|patch| patch.id == id)
    }

    /// The shard below it that leads to a patch.
    pub fn towards(&self, id: PatchId) -> Option<(PatchId, Reference)> {
        let level = self.root.level + LEVELS;
        let root = (id.level >= level).then(|| id.ancestor(level))?;
        let found = self.below.binary_search_by_key(&order(root), |(root, _)| order(*root)).ok()?;
        self.below.get(found).filter(|(there, _)| *there == root).copied()
    }

    /// Its bytes.
    pub(super) fn encode(&self) -> Vec<u8> {
        let mut raw = Vec::with_capacity(MOST_RAW);
        raw.extend(MAGIC);
        raw.extend(VERSION.to_le_bytes());
        raw.push(self.root.face.index());
        put_id(&mut raw, self.root);
        raw.extend(self.data_bytes.to_le_bytes());
        raw.extend(self.data.bytes());
        raw.extend((self.patches.len() as u16).to_le_bytes());
        raw.extend((self.below.len() as u16).to_le_bytes());
        for patch in &self.patches {
            put_id(&mut raw, patch.id);
            raw.extend(facts::bytes(&patch.facts));
            raw.extend([patch.geometry.len() as u8, patch.texture.iter().len() as u8]);
            for segment in patch.geometry.iter().chain(&patch.texture) {
                raw.extend((segment.length() as u32).to_le_bytes());
                raw.extend(segment.hash);
            }
        }
        for (root, reference) in &self.below {
            put_id(&mut raw, *root);
            raw.extend(reference.bytes.to_le_bytes());
            raw.extend(reference.object.bytes());
        }
        // A few kilobytes into a buffer of the size that zstd asks for cannot fail.
        zstd::bulk::compress(&raw, ZSTD_LEVEL).expect("zstd compresses into its own bound")
    }

    /// Reads the directory of the shard with this root.
    ///
    /// # Errors
    /// For bytes that are none, or that of another shard.
    pub fn decode(bytes: &[u8], root: PatchId) -> Result<Directory, RecordError> {
        let damaged = |e: std::io::Error| RecordError::Stream { stream: "directory", reason: e.to_string() };
        let raw = zstd::bulk::decompress(bytes, MOST_RAW).map_err(damaged)?;
        let mut reader = RecordReader::of_body(&raw);
        let found = reader.array("magic")?;
        if found != MAGIC {
            return Err(RecordError::Magic { found, expected: MAGIC });
        }
        let version = reader.u16("version")?;
        if version != VERSION {
            return Err(RecordError::Version { found: version, expected: VERSION });
        }
        let [face] = reader.array("face")?;
        let face = Face::new(face).ok_or(RecordError::Measure("there is no such face"))?;
        let there = id(&mut reader, face)?;
        if there != root || !root.level.is_multiple_of(LEVELS) {
            return Err(RecordError::Belongs { found: there.to_string(), expected: root.to_string() });
        }
        let data_bytes = u64::from_le_bytes(reader.array("length of the data")?);
        let data = ObjectName::from_bytes(reader.array("name of the data")?);
        let (patch_count, shard_count) = (reader.u16("number of patches")?, reader.u16("number of shards")?);
        let mut patches: Vec<PatchEntry> = Vec::new();
        for _ in 0..patch_count {
            let patch = patch(&mut reader, root)?;
            if patches.last().is_some_and(|last| order(last.id) >= order(patch.id)) {
                return Err(RecordError::Measure("its patches are not in order"));
            }
            patches.push(patch);
        }
        let mut below: Vec<(PatchId, Reference)> = Vec::new();
        for _ in 0..shard_count {
            let shard = id(&mut reader, face)?;
            let bytes = reader.u32("length of a directory")?;
            let object = ObjectName::from_bytes(reader.array("name of a directory")?);
            if shard.level != root.level + LEVELS || shard.ancestor(root.level) != root {
                return Err(RecordError::Measure("a shard is not below this one"));
            }
            if below.last().is_some_and(|(last, _)| order(*last) >= order(shard)) {
                return Err(RecordError::Measure("its shards are not in order"));
            }
            below.push((shard, Reference { object, bytes }));
        }
        reader.finish()?;
        if lay_out(&mut patches) != Some(data_bytes) {
            return Err(RecordError::Measure("its segments are not as long as its data"));
        }
        Ok(Directory { root, patches, below, data, data_bytes })
    }
}

fn put_id(raw: &mut Vec<u8>, id: PatchId) {
    raw.push(id.level);
    raw.extend(id.x.to_le_bytes());
    raw.extend(id.y.to_le_bytes());
}

fn id(reader: &mut RecordReader<'_>, face: Face) -> Result<PatchId, RecordError> {
    let [level] = reader.array("level")?;
    let (x, y) = (reader.u32("column")?, reader.u32("row")?);
    PatchId::new(face, level, x, y).ok_or(RecordError::Measure("there is no such patch"))
}

fn patch(reader: &mut RecordReader<'_>, root: PatchId) -> Result<PatchEntry, RecordError> {
    let id = id(reader, root.face)?;
    if id.level < root.level || root_of(id) != root {
        return Err(RecordError::Measure("a patch is not of this shard"));
    }
    let facts = facts::read(reader)?;
    facts::check(&facts).map_err(RecordError::Measure)?;
    let [chunks, textures] = reader.array("parts")?;
    if usize::from(chunks) > MOST_CHUNKS || textures > 1 {
        return Err(RecordError::Measure("a patch has more parts than patches have"));
    }
    let geometry = (0..chunks).map(|_| segment(reader)).collect::<Result<_, _>>()?;
    let texture = (textures == 1).then(|| segment(reader)).transpose()?;
    Ok(PatchEntry { id, facts, geometry, texture })
}

fn segment(reader: &mut RecordReader<'_>) -> Result<Segment, RecordError> {
    let length = reader.u32("length of a segment")?;
    if length > MOST_SEGMENT {
        return Err(RecordError::Measure("a segment is longer than any part of a patch"));
    }
    Ok(Segment { data: 0..u64::from(length), hash: reader.array("checksum of a segment")? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::lattice::LatticeBox;
    use crate::mesh::progressive::Quarter;
    use glam::IVec3;

    fn entry(id: PatchId, segments: usize) -> PatchEntry {
        let facts = PatchFacts {
            bounds: LatticeBox { low: IVec3::splat(-5), high: IVec3::splat(5) },
            heights: [-7, -7],
            child_wake: f64::INFINITY,
            quarters: [Quarter { heights: [-7, -7], deviation: 0.5 }; 4],
        };
        let geometry = (0..segments).map(|k| Segment::of(&vec![k as u8; 10 + k])).collect();
        let texture = Some(Segment::of(&[9; 100]));
        PatchEntry { id, facts, geometry, texture }
    }

    fn full(root: PatchId) -> Directory {
        let mut patches = vec![entry(root, 3)];
        let mut from = vec![root];
        for _ in 1..LEVELS {
            from = from.iter().flat_map(|id| id.children().unwrap()).collect();
            patches.extend(from.iter().map(|id| entry(*id, 3)));
        }
        let mut below: Vec<(PatchId, Reference)> =
            from.iter().flat_map(|id| id.children().unwrap()).map(|id| (id, Reference::to(&[id.x as u8]))).collect();
        below.sort_by_key(|(id, _)| order(*id));
        Directory::new(root, patches, below)
    }

    #[test]
    fn what_is_written_is_read_and_lies_layer_by_layer() {
        let root = PatchId::new(Face::ALL[2], 6, 17, 40).unwrap();
        let directory = full(root);
        assert_eq!((directory.patches.len(), directory.below.len()), (21, 64));
        let bytes = directory.encode();
        assert_eq!(Directory::decode(&bytes, root), Ok(directory.clone()));
        let (first, last) = (&directory.patches[0], &directory.patches[20]);
        assert_eq!(first.geometry[0].data, 0..10);
        assert_eq!(last.geometry[0].data, 200..210);
        assert_eq!(first.texture.as_ref().unwrap().data, 210..310);
        assert_eq!(first.geometry[1].data.start, 210 + 2100);
        assert_eq!(last.geometry[2].data.end, directory.data_bytes);
        let deep = root.children().unwrap()[2].children().unwrap()[1].children().unwrap()[3].children().unwrap()[0];
        assert_eq!(directory.towards(deep).unwrap().0, deep.ancestor(9));
        assert_eq!(directory.patch(deep.ancestor(8)).unwrap().id, deep.ancestor(8));
        assert!(directory.patch(deep).is_none() && directory.towards(deep.ancestor(8)).is_none());
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic() {
        let root = PatchId::new(Face::ALL[2], 6, 17, 40).unwrap();
        let raw = zstd::bulk::decompress(&full(root).encode(), MOST_RAW).unwrap();
        let pack = |raw: &[u8]| zstd::bulk::compress(raw, 1).unwrap();
        for end in 0..raw.len() {
            assert!(Directory::decode(&pack(&raw[..end]), root).is_err(), "cut after {end}");
        }
        for at in 0..raw.len() {
            for bit in [1, 128] {
                let mut changed = raw.clone();
                changed[at] ^= bit;
                // A changed checksum or name is not noticed here, but where its bytes are.
                let _ = Directory::decode(&pack(&changed), root);
            }
        }
        let other = PatchId::new(Face::ALL[2], 6, 17, 41).unwrap();
        assert!(matches!(Directory::decode(&pack(&raw), other), Err(RecordError::Belongs { .. })));
        assert!(Directory::decode(b"not zstd", root).is_err());
    }
}
