//! What was fetched before, in the user's cache: stretches of objects, which are right for ever since objects are named by what they hold, and
//! the last `planet.json` of each address. Whoever reads them checks them, so nothing here need survive a crash.

use rusqlite::{params, Connection, OptionalExtension};
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use terrane_planet::published::ObjectName;

const TABLES: &str = "
CREATE TABLE IF NOT EXISTS stretch (
    object TEXT NOT NULL, first INTEGER NOT NULL, used INTEGER NOT NULL, bytes BLOB NOT NULL, PRIMARY KEY (object, first));
CREATE TABLE IF NOT EXISTS manifest (address TEXT PRIMARY KEY, tag TEXT NOT NULL, bytes BLOB NOT NULL);
";

/// What of the budget is left when something had to go.
const KEPT: f64 = 0.8;

/// How long to wait for another process.
const BUSY: Duration = Duration::from_secs(2);

/// The cache of what was fetched.
pub(crate) struct FetchCache {
    connection: Mutex<Connection>,
}

/// Days since 1970: how exactly it is known when something was used.
fn today() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| (since.as_secs() / 86_400) as i64)
}

impl FetchCache {
    /// Opens the cache in a folder, and makes room down to a budget in bytes: what was not used for longest goes. One that is damaged is
    /// made anew.
    pub(crate) fn open(folder: &Path, budget: u64) -> Option<FetchCache> {
        let path = folder.join("fetched.sqlite");
        let open = || -> rusqlite::Result<Connection> {
            let connection = Connection::open(&path)?;
            connection.busy_timeout(BUSY)?;
            connection.pragma_update(None, "journal_mode", "WAL")?;
            connection.pragma_update(None, "synchronous", "OFF")?;
            connection.execute_batch(TABLES)?;
            make_room(&connection, budget)?;
            Ok(connection)
        };
        // If this fails, so does what follows, with a better message.
        let _ = std::fs::create_dir_all(folder);
        let opened = open().or_else(|error| {
            let is_damaged = [rusqlite::ErrorCode::NotADatabase, rusqlite::ErrorCode::DatabaseCorrupt].map(Some);
            if !is_damaged.contains(&error.sqlite_error_code()) {
                return Err(error);
            }
            tracing::warn!(%error, "the cache {} is made anew", path.display());
            // With what SQLite keeps beside it: that of another file would be taken for its own.
            for beside in ["", "-wal", "-shm"] {
                let _ = std::fs::remove_file(folder.join(format!("fetched.sqlite{beside}")));
            }
            open()
        });
        match opened {
            Ok(connection) => Some(FetchCache { connection: Mutex::new(connection) }),
            Err(error) => {
                tracing::warn!(%error, "what is fetched is not kept: {}", path.display());
                None
            }
        }
    }

    /// A stretch of an object, if it is there.
    pub(super) fn stretch(&self, object: ObjectName, range: &Range<u64>) -> Option<Vec<u8>> {
        let (connection, key) = (self.lock(), params![object.to_string(), range.start as i64]);
        let query = "SELECT used, bytes FROM stretch WHERE object = ?1 AND first = ?2";
        let found =
            connection.prepare_cached(query).and_then(|mut s| s.query_row(key, |row| Ok((row.get(0)?, row.get(1)?))).optional());
        let (used, bytes): (i64, Vec<u8>) = found.inspect_err(|error| tracing::debug!(%error, "cache")).ok()??;
        if used != today() {
            let update = "UPDATE stretch SET used = ?3 WHERE object = ?1 AND first = ?2";
            // Unless another process writes: then it counts as unused.
            let _ = connection.execute(update, params![object.to_string(), range.start as i64, today()]);
        }
        Some(bytes).filter(|bytes| bytes.len() as u64 == range.end - range.start)
    }

    /// Keeps a stretch of an object.
    pub(super) fn keep(&self, object: ObjectName, first: u64, bytes: &[u8]) {
        let insert = "INSERT OR REPLACE INTO stretch VALUES (?1, ?2, ?3, ?4)";
        let connection = self.lock();
        let kept = connection
            .prepare_cached(insert)
            .and_then(|mut statement| statement.execute(params![object.to_string(), first as i64, today(), bytes]));
        if let Err(error) = kept {
            tracing::debug!(%error, "a stretch is not kept");
        }
    }

    /// The last `planet.json` of an address, and its tag.
    pub(super) fn manifest(&self, address: &str) -> Option<(String, Vec<u8>)> {
        let query = "SELECT tag, bytes FROM manifest WHERE address = ?1";
        let found = self.lock().query_row(query, [address], |row| Ok((row.get(0)?, row.get(1)?))).optional();
        found.inspect_err(|error| tracing::debug!(%error, "cache")).ok()?
    }

    /// Keeps the `planet.json` of an address.
    pub(super) fn keep_manifest(&self, address: &str, tag: &str, bytes: &[u8]) {
        let kept = self.lock().execute("INSERT OR REPLACE INTO manifest VALUES (?1, ?2, ?3)", params![address, tag, bytes]);
        if let Err(error) = kept {
            tracing::debug!(%error, "a planet.json is not kept");
        }
    }

    fn lock(&self) -> MutexGuard<'_, Connection> {
        self.connection.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Removes stretches, those unused for longest first, if there are more than a budget allows.
fn make_room(connection: &Connection, budget: u64) -> rusqlite::Result<()> {
    let there: i64 = connection.query_row("SELECT coalesce(sum(length(bytes)), 0) FROM stretch", [], |row| row.get(0))?;
    let most = i64::try_from(budget).unwrap_or(i64::MAX);
    if there <= most {
        return Ok(());
    }
    let mut excess = there - (most as f64 * KEPT) as i64;
    let transaction = connection.unchecked_transaction()?;
    {
        let mut oldest = transaction.prepare("SELECT rowid, length(bytes) FROM stretch ORDER BY used")?;
        let mut rows = oldest.query([])?;
        let mut remove = transaction.prepare("DELETE FROM stretch WHERE rowid = ?1")?;
        while let Some(row) = rows.next()?.filter(|_| excess > 0) {
            let (id, bytes): (i64, i64) = (row.get(0)?, row.get(1)?);
            remove.execute([id])?;
            excess -= bytes;
        }
    }
    transaction.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_there_again_within_the_budget_and_damage_is_made_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let object = ObjectName::of(b"a");
        let open = |budget| FetchCache::open(folder.path(), budget).expect("a cache");
        let cache = open(10_000);
        (0..20).for_each(|k| cache.keep(object, 1000 * k, &[k as u8; 1000]));
        assert_eq!(cache.stretch(object, &(3000..4000)), Some(vec![3; 1000]));
        assert_eq!((cache.stretch(object, &(3000..3999)), cache.stretch(ObjectName::of(b"b"), &(0..1000))), (None, None));
        cache.keep_manifest("http://a/planet.json", "\"1\"", b"{}");
        drop(cache);
        let cache = open(10_000);
        let left = (0..20).filter(|k| cache.stretch(object, &(1000 * k..1000 * k + 1000)).is_some()).count();
        assert_eq!(left, 8);
        assert_eq!(cache.manifest("http://a/planet.json"), Some(("\"1\"".to_owned(), b"{}".to_vec())));
        drop(cache);
        std::fs::write(folder.path().join("fetched.sqlite"), b"no database at all, but long enough to look at").expect("a file");
        assert!(open(10_000).manifest("http://a/planet.json").is_none());
    }
}
