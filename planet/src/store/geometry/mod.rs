//! The geometry record: a [`PatchMesh`] as chunks by wake.
//!
//! Vertices are in wake order, and whoever looks from afar wakes the first of them only. So a record begins with its *head* (facts, and
//! where the chunks are), and each chunk holds the vertices that follow those of the chunks before it: it is decoded after these and
//! without anything else, and has a checksum of its own. A reader takes as many chunks as its view can wake.

mod chunk;
mod falls;
mod raw;

pub use raw::{of_raw, seal};

use super::error::RecordError;
use super::facts;
use super::record::{RecordReader, RecordWriter, HEADER_BYTES};
use crate::globe::lattice::EXTENT;
use crate::globe::patch::{PatchId, MAX_CELLS, MIN_CELLS};
use crate::mesh::progressive::{MeshPrefix, PatchFacts, PatchMesh, Vertex};
use crate::mesh::wake::Wake;
use chunk::{Numbers, Vertices};
use std::ops::Range;

/// First bytes of a geometry record.
pub const MAGIC: [u8; 4] = *b"TRPG";

/// Fewest vertices of the first chunk, if there are several: the streams of a smaller one would cost more than they hold.
const LEAST_CHUNK: usize = 256;

/// Bytes of the head for each chunk: length 4, checksum 4, largest wake of what follows it 2.
const CHUNK_BYTES: usize = 10;

/// Whether patches of so many cells a side exist.
pub(super) fn cells_are_valid(cells: u32) -> bool {
    cells.is_power_of_two() && (MIN_CELLS..=MAX_CELLS).contains(&cells)
}

fn samples(cells: u32) -> usize {
    (cells as usize + 1).pow(2)
}

/// How many vertices there are, from the start of the wake order, up to the end of each chunk: all, and before that a quarter each of what
/// follows. 264, 1,056 and 4,225 of a grid of 64 cells.
pub fn chunk_ends(cells: u32) -> Vec<usize> {
    let quarter = |&end: &usize| Some(end / 4).filter(|&end| end >= LEAST_CHUNK);
    let mut ends: Vec<usize> = std::iter::successors(Some(samples(cells)), quarter).collect();
    ends.reverse();
    ends
}

/// Bytes of a record's head.
pub fn head_bytes(cells: u32) -> usize {
    HEADER_BYTES + facts::BYTES + CHUNK_BYTES * chunk_ends(cells).len()
}

/// What a record says before its chunks.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// The mesh's facts.
    pub facts: PatchFacts,
    /// Its chunks.
    pub chunks: Vec<Chunk>,
}

/// Where a chunk is, and what it leaves out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Vertices up to its end.
    pub end: usize,
    /// Its bytes, from the start of the record.
    pub bytes: Range<usize>,
    /// The largest wake of the vertices after it; [`Wake::ASLEEP`] if there are none.
    pub beyond: Wake,
    checksum: u32,
}

impl Head {
    /// The head of a record, of which `bytes` are the first [`head_bytes`] or more.
    ///
    /// # Errors
    /// For bytes that are not the head of a record of this patch and grid.
    pub fn read(bytes: &[u8], id: PatchId, cells: u32) -> Result<Head, RecordError> {
        if !cells_are_valid(cells) {
            return Err(RecordError::Measure("the grid's cells are not a power of two in range"));
        }
        let ends = chunk_ends(cells);
        let (mut record, _) = RecordReader::open_head(bytes, MAGIC, id, cells)?;
        let raw = facts::BYTES + CHUNK_BYTES * ends.len();
        if record.raw != raw {
            return Err(RecordError::Short { what: "raw record", found: record.raw, expected: raw });
        }
        let facts = facts::read(&mut record)?;
        facts::check(&facts).map_err(RecordError::Measure)?;
        let mut at = head_bytes(cells);
        let mut chunks = Vec::with_capacity(ends.len());
        for end in ends {
            let (bytes, checksum) = (record.u32("length of a chunk")? as usize, record.u32("checksum of a chunk")?);
            let beyond = Wake::from_code(record.u16("wake beyond a chunk")?);
            let start = at;
            at = start.saturating_add(bytes);
            chunks.push(Chunk { end, bytes: start..at, beyond, checksum });
        }
        record.finish()?;
        Ok(Head { facts, chunks })
    }

    /// How many chunks hold all that is `enough`: a condition on the largest wake of what is left out.
    pub fn chunks_until(&self, enough: &dyn Fn(&PatchFacts, Wake) -> bool) -> usize {
        let short = self.chunks.iter().take_while(|chunk| chunk.beyond != Wake::ASLEEP && !enough(&self.facts, chunk.beyond));
        (short.count() + 1).min(self.chunks.len())
    }

    /// Bytes of the record up to the end of so many chunks, at least one.
    pub fn bytes_of(&self, chunks: usize) -> usize {
        self.chunks[chunks.clamp(1, self.chunks.len()) - 1].bytes.end
    }
}

/// The record of a mesh, or which of the builder's promises it breaks (nothing is stored that could not be read back).
pub fn encode(mesh: &PatchMesh) -> Result<Vec<u8>, RecordError> {
    validate(mesh)?;
    let ends = chunk_ends(mesh.cells);
    let beyond = ends.iter().map(|&end| mesh.vertices.get(end).map_or(Wake::ASLEEP, Vertex::largest_wake));
    let bytes = chunk::numbers(mesh, &ends).into_iter().map(|numbers| numbers.write());
    Ok(assemble(mesh.id, mesh.cells, &facts::bytes(&mesh.facts), &beyond.zip(bytes).collect::<Vec<_>>()))
}

/// The record of facts and chunks: of each the largest wake beyond it, and its bytes.
fn assemble(id: PatchId, cells: u32, facts: &[u8], chunks: &[(Wake, Vec<u8>)]) -> Vec<u8> {
    let mut record = RecordWriter::new(MAGIC, id, cells);
    record.plain(facts);
    for (beyond, bytes) in chunks {
        record.plain(&(bytes.len() as u32).to_le_bytes());
        record.plain(&crc32fast::hash(bytes).to_le_bytes());
        record.plain(&beyond.code().to_le_bytes());
    }
    let mut record = record.finish();
    chunks.iter().for_each(|(_, bytes)| record.extend(bytes));
    record
}

/// The mesh of a record, after every check that keeps a reader of it safe.
pub fn decode(bytes: &[u8], id: PatchId, cells: u32) -> Result<PatchMesh, RecordError> {
    let head = Head::read(bytes, id, cells)?;
    let end = head.bytes_of(head.chunks.len());
    if bytes.len() > end {
        return Err(RecordError::Trailing(bytes.len() - end));
    }
    decode_chunks(&head, bytes, id, cells, head.chunks.len()).map(|prefix| prefix.mesh)
}

/// What the first `chunks` chunks of a record hold, at least one, after every check that keeps a reader of it safe. `bytes` may end with the
/// last of these.
///
/// # Errors
/// For a chunk that is damaged or not there, by its number.
pub fn decode_chunks(head: &Head, bytes: &[u8], id: PatchId, cells: u32, chunks: usize) -> Result<MeshPrefix, RecordError> {
    let of = head.chunks.len();
    let chunks = chunks.clamp(1, of);
    let (mut vertices, mut reader) = (Vertices::new(cells), RecordReader::of_body(&[]));
    for (k, chunk) in head.chunks[..chunks].iter().enumerate() {
        let wrong = |reason| RecordError::Chunk { number: k + 1, of, reason: Box::new(reason) };
        reader.go_on(sound_bytes(chunk, bytes).map_err(wrong)?);
        let count = chunk.end - vertices.vertices.len();
        let numbers = Numbers::read(&mut reader, count, samples(cells), k + 1 == of).map_err(wrong)?;
        vertices.add(&numbers).map_err(wrong)?;
    }
    let beyond = head.chunks[chunks - 1].beyond;
    let mesh = PatchMesh { id, cells, vertices: vertices.vertices, facts: head.facts };
    check_heights(&mesh, chunks == of)?;
    Ok(MeshPrefix { mesh, falls: vertices.falls, beyond })
}

/// The bytes of a chunk in a record, if they are those that were written.
fn sound_bytes<'a>(chunk: &Chunk, record: &'a [u8]) -> Result<&'a [u8], RecordError> {
    let found = record.len().saturating_sub(chunk.bytes.start);
    let short = RecordError::Short { what: "record", found, expected: chunk.bytes.len() };
    let bytes = record.get(chunk.bytes.clone()).ok_or(short)?;
    let found = crc32fast::hash(bytes);
    if found != chunk.checksum {
        return Err(RecordError::Checksum { found, expected: chunk.checksum });
    }
    Ok(bytes)
}

/// Everything that readers of a mesh rely on.
fn validate(mesh: &PatchMesh) -> Result<(), RecordError> {
    if !cells_are_valid(mesh.cells) || mesh.vertices.len() != samples(mesh.cells) {
        return Err(RecordError::Short { what: "vertex list", found: mesh.vertices.len(), expected: samples(mesh.cells) });
    }
    let mut seen = vec![false; mesh.vertices.len()];
    let mut previous = Wake::ALWAYS;
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        let wrong = |reason| Err(RecordError::Vertex { index, reason });
        match seen.get_mut(usize::from(vertex.grid)) {
            Some(slot) if !*slot => *slot = true,
            _ => return wrong("its grid position is taken or outside the grid"),
        }
        if usize::from(vertex.parent) > index {
            return wrong("its parent comes after it");
        }
        if vertex.largest_wake() > previous {
            return wrong("its wake is larger than the one before");
        }
        if vertex.height.unsigned_abs() > EXTENT.unsigned_abs() {
            return wrong("its height is outside the lattice");
        }
        previous = vertex.largest_wake();
    }
    check_heights(mesh, true)?;
    facts::check(&mesh.facts).map_err(RecordError::Measure)
}

/// Checks that the stated height range is that of the vertices or, if these are not all, holds them.
fn check_heights(mesh: &PatchMesh, is_whole: bool) -> Result<(), RecordError> {
    let heights = || mesh.vertices.iter().map(|vertex| vertex.height);
    let (low, high) = (heights().min().unwrap_or(0), heights().max().unwrap_or(0));
    let [lowest, highest] = mesh.facts.heights;
    if low < lowest || high > highest || (is_whole && [low, high] != [lowest, highest]) {
        return Err(RecordError::Measure("the height range is not that of the vertices"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::lattice::LatticeBox;
    use crate::mesh::progressive::Quarter;
    use glam::IVec3;

    /// A mesh that satisfies every rule: all vertices are asleep but the first, which is the parent of all.
    fn flat(cells: u32) -> PatchMesh {
        let vertex = |grid: u32| {
            let wake = if grid == 0 { Wake::ALWAYS } else { Wake::ASLEEP };
            Vertex { grid: grid as u16, height: -7, wake, coarser_wake: wake, parent: 0 }
        };
        PatchMesh {
            id: PatchId::new(crate::globe::sphere::Face::ALL[2], 3, 1, 6).unwrap(),
            cells,
            vertices: (0..(cells + 1) * (cells + 1)).map(vertex).collect(),
            facts: PatchFacts {
                bounds: LatticeBox { low: IVec3::splat(-5), high: IVec3::splat(5) },
                heights: [-7, -7],
                child_wake: f64::INFINITY,
                quarters: [Quarter { heights: [-7, -7], deviation: 0.5 }; 4],
            },
        }
    }

    /// Decodes a record with valid checksums around chunks of which one was changed.
    fn decode_changed(cells: u32, change: impl Fn(&mut [Numbers])) -> Result<PatchMesh, RecordError> {
        let mesh = flat(cells);
        let mut numbers = chunk::numbers(&mesh, &chunk_ends(cells));
        change(&mut numbers);
        let chunks: Vec<_> = numbers.iter().map(|numbers| (Wake::ASLEEP, numbers.write())).collect();
        decode(&assemble(mesh.id, cells, &facts::bytes(&mesh.facts), &chunks), mesh.id, cells)
    }

    #[test]
    fn chunks_grow_fourfold_and_end_with_the_grid() {
        assert_eq!(chunk_ends(8), [81]);
        assert_eq!(chunk_ends(32), [272, 1089]);
        assert_eq!(chunk_ends(64), [264, 1056, 4225]);
        assert_eq!(chunk_ends(128), [260, 1040, 4160, 16_641]);
    }

    #[test]
    fn sound_chunks_decode() {
        for cells in [8, 32] {
            assert_eq!(decode_changed(cells, |_| ()), Ok(flat(cells)));
        }
    }

    #[test]
    fn chunks_that_break_a_rule_are_refused_by_name() {
        type Change = fn(&mut [Vec<u32>; 6]);
        let cases: [(&str, Change); 9] = [
            ("falls below zero", |s| s[0][5] = 9),
            ("position is taken", |s| s[1][7] = s[1][6]),
            ("outside the grid", |s| s[1][7] = 33 << 8),
            ("no vertex of its region", |s| s[2][3] = 4),
            ("falls below zero", |s| s[3][3] = 1),
            ("neither of its wakes", |s| (s[3][0], s[4][0]) = (1, 1)),
            ("height range", |s| s[5][8] = 2),
            ("outside the lattice", |s| s[5][80] = u32::MAX),
            ("outside the grid", |s| s[1][0] = 0xffff),
        ];
        for (reason, change) in cases {
            for cells in [8, 32] {
                let error = decode_changed(cells, |chunks| change(&mut chunks[0].of_vertices)).unwrap_err().to_string();
                assert!(error.contains(reason), "expected '{reason}', found '{error}'");
            }
        }
        let in_the_second = decode_changed(32, |chunks| chunks[1].of_vertices[1][0] = 0).unwrap_err().to_string();
        assert!(in_the_second.contains("chunk 2 of 2: vertex 272: its grid position is taken"), "{in_the_second}");
        let falls: [fn(&mut Vec<u32>); 3] = [|falls| falls[0] = 9999, |falls| falls.push(0), |falls| falls.truncate(5)];
        for change in falls {
            let error = decode_changed(32, |chunks| change(chunks[0].falls.as_mut().unwrap())).unwrap_err();
            assert!(matches!(error, RecordError::Chunk { number: 1, of: 2, .. }), "{error}");
        }
    }

    #[test]
    fn meshes_that_break_a_rule_are_not_encoded() {
        let cases: [fn(&mut PatchMesh); 7] = [
            |m| m.vertices[4].parent = 9,
            |m| m.vertices[4].grid = 5,
            |m| m.vertices[4].wake = Wake::ALWAYS,
            |m| m.facts.quarters[2].deviation = f64::NAN,
            |m| m.facts.heights = [0, 0],
            |m| m.facts.bounds = LatticeBox::EMPTY,
            |m| m.cells = 16,
        ];
        for (k, change) in cases.into_iter().enumerate() {
            let mut mesh = flat(8);
            change(&mut mesh);
            assert!(encode(&mesh).is_err(), "case {k}");
        }
    }
}
