//! The envelope of a patch record: magic, version, patch, lengths and checksum, then one zstd frame a stream.
//!
//! All numbers are little-endian. A reader knows every stream's raw length from the cells of the grid, so no length in the
//! record ever decides how much memory is taken.

use super::error::RecordError;
use crate::globe::patch::PatchId;
use crate::globe::sphere::Face;

/// Version of the records that this program writes and reads.
pub const RECORD_VERSION: u16 = 3;

/// Compression level of every stream. Fixed: a patch has the same bytes wherever it is baked. Residuals repeat nothing, so that
/// searching longer for repetitions (level 9) saves nothing either.
pub const ZSTD_LEVEL: i32 = 1;

/// Bytes before the body: magic 4, version 2, cells 2, face 1, level 1, x 4, y 4, raw length 4, body length 4, checksum 4.
pub const HEADER_BYTES: usize = 30;

/// Where the checksum stands in the header.
const CHECKSUM_AT: usize = HEADER_BYTES - 4;

/// Writes one record. Public for tests and fuzzing, which need records that are sound but for what they hold.
pub struct RecordWriter {
    bytes: Vec<u8>,
    raw: usize,
}

impl RecordWriter {
    /// The record of a patch on a grid of `cells`, still without a body.
    pub fn new(magic: [u8; 4], id: PatchId, cells: u32) -> RecordWriter {
        let mut bytes = Vec::with_capacity(1 << 16);
        bytes.extend(magic);
        bytes.extend(RECORD_VERSION.to_le_bytes());
        bytes.extend((cells as u16).to_le_bytes());
        bytes.extend([id.face.index(), id.level]);
        bytes.extend(id.x.to_le_bytes());
        bytes.extend(id.y.to_le_bytes());
        bytes.extend([0; 12]);
        RecordWriter { bytes, raw: 0 }
    }

    /// Adds bytes as they are.
    pub fn plain(&mut self, bytes: &[u8]) {
        self.raw += bytes.len();
        self.bytes.extend(bytes);
    }

    /// Adds a compressed stream.
    pub fn stream(&mut self, bytes: &[u8]) {
        self.raw += bytes.len();
        add_stream(&mut self.bytes, bytes);
    }

    /// The record, with its lengths and checksum.
    pub fn finish(mut self) -> Vec<u8> {
        state(&mut self.bytes, self.raw as u32);
        self.bytes
    }
}

/// Adds a compressed stream and, before it, its length. Nothing follows a length of 0, which says that all bytes are 0.
pub(super) fn add_stream(to: &mut Vec<u8>, bytes: &[u8]) {
    if bytes.iter().all(|&byte| byte == 0) {
        to.extend([0; 4]);
        return;
    }
    add_packed(to, bytes);
}

/// [`add_stream`] for bytes whose number the reader does not know.
pub(super) fn add_packed(to: &mut Vec<u8>, bytes: &[u8]) {
    // A frame of at most a few hundred kilobytes into a buffer of the size that zstd asks for cannot fail.
    let packed = zstd::bulk::compress(bytes, ZSTD_LEVEL).expect("zstd compresses into its own bound");
    to.extend((packed.len() as u32).to_le_bytes());
    to.extend(packed);
}

/// Writes the lengths and the checksum into a record's header.
fn state(bytes: &mut [u8], raw: u32) {
    let body = (bytes.len() - HEADER_BYTES) as u32;
    bytes[CHECKSUM_AT - 8..CHECKSUM_AT - 4].copy_from_slice(&raw.to_le_bytes());
    bytes[CHECKSUM_AT - 4..CHECKSUM_AT].copy_from_slice(&body.to_le_bytes());
    let crc = checksum(bytes);
    bytes[CHECKSUM_AT..HEADER_BYTES].copy_from_slice(&crc.to_le_bytes());
}

/// Gives bytes the header that a record of this patch has, but for the raw length, which stays as it is: for fuzzing, which
/// would never get past the checksum. False for fewer bytes than a header has.
pub fn seal(bytes: &mut [u8], magic: [u8; 4], id: PatchId, cells: u32) -> bool {
    if bytes.len() < HEADER_BYTES {
        return false;
    }
    let header = RecordWriter::new(magic, id, cells).bytes;
    let stated = CHECKSUM_AT - 8;
    bytes[..stated].copy_from_slice(&header[..stated]);
    let raw = u32::from_le_bytes([bytes[stated], bytes[stated + 1], bytes[stated + 2], bytes[stated + 3]]);
    state(bytes, raw);
    true
}

/// Checksum of a record: everything but the four bytes that hold it.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..CHECKSUM_AT]);
    hasher.update(&bytes[HEADER_BYTES..]);
    hasher.finalize()
}

/// Reads one record whose envelope is sound.
pub(crate) struct RecordReader<'a> {
    bytes: &'a [u8],
    /// Made for the first stream: it takes longer to make than most streams to read.
    decompressor: Option<zstd::bulk::Decompressor<'static>>,
    /// Raw length that the record states.
    pub(super) raw: usize,
}

impl<'a> RecordReader<'a> {
    /// Checks magic, version, lengths, checksum, patch and cells, in this order.
    pub(super) fn open(bytes: &'a [u8], magic: [u8; 4], id: PatchId, cells: u32) -> Result<RecordReader<'a>, RecordError> {
        match RecordReader::open_head(bytes, magic, id, cells)? {
            (record, []) => Ok(record),
            (_, rest) => Err(RecordError::Trailing(rest.len())),
        }
    }

    /// Reads what has no envelope of its own.
    pub(crate) fn of_body(bytes: &'a [u8]) -> RecordReader<'a> {
        RecordReader { bytes, decompressor: None, raw: 0 }
    }

    /// Goes on with other bytes.
    pub(super) fn go_on(&mut self, bytes: &'a [u8]) {
        self.bytes = bytes;
    }

    /// [`RecordReader::open`] for a record that bytes of another kind may follow: these too.
    pub(super) fn open_head(
        bytes: &'a [u8],
        magic: [u8; 4],
        id: PatchId,
        cells: u32,
    ) -> Result<(RecordReader<'a>, &'a [u8]), RecordError> {
        if bytes.len() < HEADER_BYTES {
            return Err(RecordError::Short { what: "record", found: bytes.len(), expected: HEADER_BYTES });
        }
        let (header, body) = bytes.split_at(HEADER_BYTES);
        let mut fields = RecordReader::of_body(header);
        let found = fields.array::<4>("magic")?;
        if found != magic {
            return Err(RecordError::Magic { found, expected: magic });
        }
        let version = u16::from_le_bytes(fields.array("version")?);
        if version != RECORD_VERSION {
            return Err(RecordError::Version { found: version, expected: RECORD_VERSION });
        }
        let record_cells = u32::from(u16::from_le_bytes(fields.array("cells")?));
        let [face, level] = fields.array("face and level")?;
        let (x, y) = (fields.u32("column")?, fields.u32("row")?);
        let (raw, stated, expected) = (fields.u32("raw length")?, fields.u32("body length")?, fields.u32("checksum")?);
        let Some((body, rest)) = body.split_at_checked(stated as usize) else {
            return Err(RecordError::Short { what: "record body", found: body.len(), expected: stated as usize });
        };
        let found = checksum(&bytes[..HEADER_BYTES + body.len()]);
        if found != expected {
            return Err(RecordError::Checksum { found, expected });
        }
        let owner = Face::new(face).and_then(|face| PatchId::new(face, level, x, y));
        if owner != Some(id) || record_cells != cells {
            let name = owner.map_or_else(|| format!("no patch ({face}/{level}/{x}/{y})"), |id| id.to_string());
            let found = format!("{name} with {record_cells} cells");
            return Err(RecordError::Belongs { found, expected: format!("{id} with {cells} cells") });
        }
        Ok((RecordReader { raw: raw as usize, ..RecordReader::of_body(body) }, rest))
    }

    fn take(&mut self, count: usize, what: &'static str) -> Result<&'a [u8], RecordError> {
        if count > self.bytes.len() {
            return Err(RecordError::Short { what, found: self.bytes.len(), expected: count });
        }
        let (head, rest) = self.bytes.split_at(count);
        self.bytes = rest;
        Ok(head)
    }

    /// The next bytes as they are.
    pub(crate) fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], RecordError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, what)?);
        Ok(array)
    }

    pub(crate) fn u16(&mut self, what: &'static str) -> Result<u16, RecordError> {
        Ok(u16::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, RecordError> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    pub(super) fn i32(&mut self, what: &'static str) -> Result<i32, RecordError> {
        Ok(i32::from_le_bytes(self.array(what)?))
    }

    pub(super) fn f64(&mut self, what: &'static str) -> Result<f64, RecordError> {
        Ok(f64::from_le_bytes(self.array(what)?))
    }

    /// The next stream, which must decompress to exactly `raw` bytes.
    pub(super) fn stream(&mut self, stream: &'static str, raw: usize) -> Result<Vec<u8>, RecordError> {
        if let Some((&[0, 0, 0, 0], rest)) = self.bytes.split_first_chunk() {
            self.bytes = rest;
            return Ok(vec![0; raw]);
        }
        let bytes = self.stream_within(stream, raw)?;
        if bytes.len() != raw {
            return Err(RecordError::Stream { stream, reason: format!("{} bytes, expected {raw}", bytes.len()) });
        }
        Ok(bytes)
    }

    /// The next stream, which must decompress to at most `most` bytes.
    pub(super) fn stream_within(&mut self, stream: &'static str, most: usize) -> Result<Vec<u8>, RecordError> {
        let packed = self.u32(stream)? as usize;
        let packed = self.take(packed, stream)?;
        let damaged = |e: std::io::Error| RecordError::Stream { stream, reason: e.to_string() };
        let decompressor = match &mut self.decompressor {
            Some(there) => there,
            none => none.insert(zstd::bulk::Decompressor::new().map_err(damaged)?),
        };
        decompressor.decompress(packed, most).map_err(damaged)
    }

    /// Ends the record: nothing may follow.
    pub(crate) fn finish(&self) -> Result<(), RecordError> {
        if self.bytes.is_empty() {
            Ok(())
        } else {
            Err(RecordError::Trailing(self.bytes.len()))
        }
    }
}
