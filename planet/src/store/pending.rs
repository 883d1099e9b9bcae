//! Which patches a file has still to get back: removed by an edit of the ground, not yet built again. To readers they are absent.
//!
//! The table is there from a file's first edit on, so files without edits are as they always were.

use super::rows;
use crate::patch::PatchId;
use rusqlite::Connection;

fn exists(connection: &Connection) -> rusqlite::Result<bool> {
    connection.prepare_cached("SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = 'pending'")?.exists([])
}

/// All of them, in no order; `None` for a row that names no patch.
pub(super) fn list(connection: &Connection) -> rusqlite::Result<Vec<Option<PatchId>>> {
    if !exists(connection)? {
        return Ok(Vec::new());
    }
    let mut statement = connection.prepare("SELECT key FROM pending")?;
    let ids = statement.query_map([], |row| row.get(0).map(rows::id))?.collect();
    ids
}

/// Removes patches of the file. Those that were there to stay are pending from now on; cached ones just go.
pub(super) fn put_off(connection: &Connection, ids: &[PatchId]) -> rusqlite::Result<()> {
    connection.execute_batch("CREATE TABLE IF NOT EXISTS pending (key INTEGER PRIMARY KEY)")?;
    let mut uncache = connection.prepare_cached("DELETE FROM cached WHERE key = ?1")?;
    let mut insert = connection.prepare_cached("INSERT OR IGNORE INTO pending VALUES (?1)")?;
    ids.iter().map(|&id| rows::key(id)).try_for_each(|key| {
        rows::remove(connection, key)?;
        if uncache.execute([key])? == 0 {
            insert.execute([key])?;
        }
        Ok(())
    })
}

/// Notes that patches are back.
pub(super) fn done(connection: &Connection, ids: impl Iterator<Item = PatchId>) -> rusqlite::Result<()> {
    if !exists(connection)? {
        return Ok(());
    }
    let mut statement = connection.prepare_cached("DELETE FROM pending WHERE key = ?1")?;
    ids.into_iter().try_for_each(|id| statement.execute([rows::key(id)]).map(drop))
}
