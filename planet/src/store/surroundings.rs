//! Heights around patches ([`sample_surroundings`](crate::ground::surroundings::sample_surroundings)), which horizon maps need and which take
//! longer to sample than to read.
//!
//! They follow from the planet alone, and a file may lack those of any patch: whoever misses them samples them again. They come and go with their patch.

use super::error::RecordError;
use super::geometry::cells_are_valid;
use super::predict::{merge_plane, plane, unzigzag, zigzag};
use super::record::{RecordReader, RecordWriter};
use super::rows;
use crate::globe::patch::PatchId;
use crate::ground::surroundings::surroundings_side;
use rusqlite::{params, Connection};

/// First bytes of a record of heights around a patch.
pub const MAGIC: [u8; 4] = *b"TRPS";

/// The bytes of a number.
const PLANES: u32 = 4;

/// Encoded heights around a patch.
pub type SurroundingsRecord = (PatchId, Vec<u8>);

/// The record of the heights around a patch of `cells` cells a side, or why it has none.
pub fn encode(heights: &[i32], id: PatchId, cells: u32) -> Result<Vec<u8>, RecordError> {
    let side = side(cells)?;
    if heights.len() != side * side {
        return Err(RecordError::Short { what: "surroundings", found: heights.len(), expected: side * side });
    }
    let residual = |k: usize| zigzag(heights[k].wrapping_sub(prediction(heights, k, side)));
    let residuals: Vec<u32> = (0..heights.len()).map(residual).collect();
    let planes: Vec<u8> = (0..PLANES).flat_map(|p| plane(&residuals, p)).collect();
    let mut record = RecordWriter::new(MAGIC, id, cells);
    record.stream(&planes);
    Ok(record.finish())
}

/// The heights of a record.
pub fn decode(bytes: &[u8], id: PatchId, cells: u32) -> Result<Vec<i32>, RecordError> {
    let side = side(cells)?;
    let count = side * side;
    let mut record = RecordReader::open(bytes, MAGIC, id, cells)?;
    let expected = PLANES as usize * count;
    if record.raw != expected {
        return Err(RecordError::Short { what: "raw record", found: record.raw, expected });
    }
    let planes = record.stream("heights", expected)?;
    record.finish()?;
    let mut residuals = vec![0; count];
    for (p, bytes) in planes.chunks_exact(count).enumerate() {
        merge_plane(&mut residuals, bytes, p as u32);
    }
    let mut heights = vec![0i32; count];
    for k in 0..count {
        heights[k] = prediction(&heights, k, side).wrapping_add(unzigzag(residuals[k]));
    }
    Ok(heights)
}

/// What a height is expected to be after those to the left and above: on the plane through them.
fn prediction(heights: &[i32], k: usize, side: usize) -> i32 {
    match (k / side, k % side) {
        (0, 0) => 0,
        (0, _) => heights[k - 1],
        (_, 0) => heights[k - side],
        _ => heights[k - 1].wrapping_add(heights[k - side]).wrapping_sub(heights[k - side - 1]),
    }
}

fn side(cells: u32) -> Result<usize, RecordError> {
    let wrong = RecordError::Measure("the grid's cells are not a power of two in range");
    cells_are_valid(cells).then(|| surroundings_side(cells)).ok_or(wrong)
}

/// Adds what is not there yet, of patches that have a row.
pub(super) fn insert(connection: &Connection, records: &[SurroundingsRecord]) -> rusqlite::Result<()> {
    let add = "INSERT OR IGNORE INTO surroundings SELECT key, ?2 FROM patch WHERE key = ?1";
    let mut insert = connection.prepare_cached(add)?;
    let mut count = connection.prepare_cached("UPDATE cached SET bytes = bytes + ?2 WHERE key = ?1")?;
    records.iter().try_for_each(|(id, record)| {
        if insert.execute(params![rows::key(*id), record])? > 0 {
            count.execute(params![rows::key(*id), record.len() as i64])?;
        }
        Ok(())
    })
}

/// Bytes of those of a patch; 0 if there are none.
pub(super) fn bytes(connection: &Connection, key: i64) -> rusqlite::Result<i64> {
    let mut statement = connection.prepare_cached("SELECT coalesce(sum(length(heights)), 0) FROM surroundings WHERE key = ?1")?;
    statement.query_row([key], |row| row.get(0))
}

/// Removes those of a patch, if there are any.
pub(super) fn remove(connection: &Connection, key: i64) -> rusqlite::Result<()> {
    connection.prepare_cached("DELETE FROM surroundings WHERE key = ?1")?.execute([key]).map(drop)
}

/// Removes those of all patches that are touched.
pub(super) fn forget(connection: &Connection, touched: &dyn Fn(PatchId) -> bool) -> rusqlite::Result<()> {
    let mut all = connection.prepare("SELECT key FROM surroundings")?;
    let keys = all.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<Vec<i64>>>()?;
    let mut touched = keys.into_iter().filter(|&key| rows::id(key).is_none_or(touched));
    touched.try_for_each(|key| remove(connection, key))
}
