//! Maps of a whole planet that follow from its recipe and take long to compute, kept in its file once they were.

use super::error::RecordError;
use super::imagery::{residuals, restore};
use rusqlite::{params, Connection, OptionalExtension};

/// Name of the map of clouds.
pub(super) const CLOUDS: &str = "clouds";

/// Bytes before the texels: side 4, checksum of the texels 4.
const HEADER_BYTES: usize = 8;

/// The record of a square map of `side` texels.
pub(super) fn encode(texels: &[u8], side: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER_BYTES + texels.len() / 2);
    bytes.extend((side as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(texels).to_le_bytes());
    // A frame into a buffer of the size that zstd asks for cannot fail.
    bytes.extend(
        zstd::bulk::compress(&residuals(texels, side), super::record::ZSTD_LEVEL).expect("zstd compresses into its own bound"),
    );
    bytes
}

/// The texels of a record, of which a side must be `side`.
pub(super) fn decode(bytes: &[u8], side: usize) -> Result<Vec<u8>, RecordError> {
    let Some((header, packed)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
        return Err(RecordError::Short { what: "map", found: bytes.len(), expected: HEADER_BYTES });
    };
    let [a, b, c, d, rest @ ..] = *header;
    let (found, expected) = (u32::from_le_bytes([a, b, c, d]) as usize, side);
    if found != expected {
        return Err(RecordError::Belongs { found: format!("a map of {found} texels a side"), expected: format!("{expected}") });
    }
    let damaged = |reason: String| RecordError::Stream { stream: "map", reason };
    let mut texels = zstd::bulk::decompress(packed, side * side).map_err(|e| damaged(e.to_string()))?;
    if texels.len() != side * side {
        return Err(damaged(format!("{} bytes, expected {}", texels.len(), side * side)));
    }
    restore(&mut texels, side);
    let (found, expected) = (crc32fast::hash(&texels), u32::from_le_bytes(rest));
    if found != expected {
        return Err(RecordError::Checksum { found, expected });
    }
    Ok(texels)
}

/// The record of a map, if the file has it.
pub(super) fn read(connection: &Connection, name: &str) -> rusqlite::Result<Option<Vec<u8>>> {
    connection.prepare_cached("SELECT texels FROM map WHERE name = ?1")?.query_row([name], |row| row.get(0)).optional()
}

/// Keeps the record of a map.
pub(super) fn write(connection: &Connection, name: &str, record: &[u8]) -> rusqlite::Result<()> {
    connection.execute("INSERT OR REPLACE INTO map VALUES (?1, ?2)", params![name, record]).map(drop)
}
