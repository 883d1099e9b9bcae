//! Which patches a file has still to get back: removed by an edit of the ground, not yet built again. To readers they are absent.
//!
//! The table is there from a file's first edit on, so files without edits are as they always were.

use super::rows;
use crate::globe::patch::PatchId;
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

/// Removes the patches that are touched, and returns how many. Those that were there to stay, whole, are pending from now on; cached and
/// partial ones just go.
pub(super) fn put_off(connection: &Connection, touched: &dyn Fn(PatchId) -> bool) -> rusqlite::Result<usize> {
    connection.execute_batch("CREATE TABLE IF NOT EXISTS pending (key INTEGER PRIMARY KEY)")?;
    let mut all = connection.prepare(&format!("SELECT key, {} FROM patch", rows::WHOLE))?;
    let found = all.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?.collect::<rusqlite::Result<Vec<(i64, bool)>>>()?;
    let mut uncache = connection.prepare_cached("DELETE FROM cached WHERE key = ?1")?;
    let mut insert = connection.prepare_cached("INSERT OR IGNORE INTO pending VALUES (?1)")?;
    let mut removed = 0;
    for (key, whole) in found.into_iter().filter(|&(key, _)| rows::id(key).is_some_and(touched)) {
        rows::remove(connection, key)?;
        removed += 1;
        if uncache.execute([key])? == 0 && whole {
            insert.execute([key])?;
        }
    }
    Ok(removed)
}

/// Notes that patches are back.
pub(super) fn done(connection: &Connection, ids: impl Iterator<Item = PatchId>) -> rusqlite::Result<()> {
    if !exists(connection)? {
        return Ok(());
    }
    let mut statement = connection.prepare_cached("DELETE FROM pending WHERE key = ?1")?;
    ids.into_iter().try_for_each(|id| statement.execute([rows::key(id)]).map(drop))
}
