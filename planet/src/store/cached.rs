//! Which patches of a file may go again: built while flying, kept under a budget, the least recently used removed first.

use super::baked::PatchRecord;
use super::rows::{self, Changed};
use super::surroundings;
use crate::globe::patch::PatchId;
use rusqlite::{params, Connection};

/// Bytes that a row takes at least, whatever it lacks: its facts, its keys and its place in the tree.
const ROW_BYTES: i64 = 256;

/// Bytes that a patch is counted as.
fn bytes_of(connection: &Connection, record: &PatchRecord) -> rusqlite::Result<i64> {
    let parts = (i64::from(record.geometry_bytes) + i64::from(record.texture_bytes)).max(ROW_BYTES);
    Ok(parts + surroundings::bytes(connection, rows::key(record.id))?)
}

/// Notes that new patches may go, and of others that may go how large they are now.
pub(super) fn add(connection: &Connection, patches: &[Changed], now: i64) -> rusqlite::Result<()> {
    let mut insert = connection.prepare_cached("INSERT OR REPLACE INTO cached VALUES (?1, ?2, ?3)")?;
    let mut update = connection.prepare_cached("UPDATE cached SET used = ?2, bytes = ?3 WHERE key = ?1")?;
    patches.iter().try_for_each(|Changed { record, is_new }| {
        let statement = if *is_new { &mut insert } else { &mut update };
        statement.execute(params![rows::key(record.id), now, bytes_of(connection, record)?]).map(drop)
    })
}

/// Notes that patches are to stay.
pub(super) fn keep(connection: &Connection, ids: impl Iterator<Item = PatchId>) -> rusqlite::Result<()> {
    let mut statement = connection.prepare_cached("DELETE FROM cached WHERE key = ?1")?;
    ids.into_iter().try_for_each(|id| statement.execute([rows::key(id)]).map(drop))
}

/// Notes that patches were used.
pub(super) fn touch(connection: &Connection, ids: &[PatchId], now: i64) -> rusqlite::Result<()> {
    let mut statement = connection.prepare_cached("UPDATE cached SET used = ?2 WHERE key = ?1")?;
    ids.iter().try_for_each(|&id| statement.execute(params![rows::key(id), now]).map(drop))
}

/// Bytes of all patches that may go.
pub(super) fn bytes(connection: &Connection) -> rusqlite::Result<u64> {
    connection
        .query_row("SELECT coalesce(sum(bytes), 0) FROM cached", [], |row| row.get::<_, i64>(0))
        .map(|bytes| bytes.max(0) as u64)
}

/// Removes patches, those unused for longest and of these the finest first, until at most `budget` bytes may go.
pub(super) fn evict(connection: &Connection, budget: u64) -> rusqlite::Result<()> {
    let mut excess = bytes(connection)?.saturating_sub(budget);
    if excess == 0 {
        return Ok(());
    }
    let mut oldest = connection.prepare_cached(
        "SELECT cached.key, bytes FROM cached JOIN patch ON patch.key = cached.key ORDER BY used, level DESC, cached.key",
    )?;
    let mut going = Vec::new();
    let mut found = oldest.query([])?;
    while excess > 0 {
        let Some(row) = found.next()? else { break };
        going.push(row.get::<_, i64>(0)?);
        excess = excess.saturating_sub(u64::from(row.get::<_, u32>(1)?));
    }
    let mut statement = connection.prepare_cached("DELETE FROM cached WHERE key = ?1")?;
    going.into_iter().try_for_each(|key| {
        rows::remove(connection, key)?;
        statement.execute([key]).map(drop)
    })
}
