//! Patches as rows of the patch table: keys, metadata and the checksum over both.

use super::baked::{BakedPatch, PatchRecord};
use super::{facts, surroundings};
use crate::globe::patch::PatchId;
use crate::globe::sphere::Face;
use rusqlite::{params, params_from_iter, Connection, OptionalExtension, Row, ToSql};

/// Columns that [`read`] reads, in its order.
pub(super) const COLUMNS: &str = "key, face, level, x, y, low_x, low_y, low_z, high_x, high_y, high_z, lowest, highest, \
     child_wake, quarters, always_awake, checksum, length(geometry), length(texture)";

/// Whether a row of the patch table has all its parts.
pub(super) const WHOLE: &str = "(length(geometry) > 0 AND length(texture) > 0)";

/// Where the facts begin among them, and what follows the facts.
const FACTS_AT: usize = 5;
const AFTER: usize = FACTS_AT + facts::COLUMNS;

/// The key of a patch: 3 bits of face, 5 of level, 21 each of column and row.
pub(super) fn key(id: PatchId) -> i64 {
    (i64::from(id.face.index()) << 5 | i64::from(id.level)) << 42 | i64::from(id.x) << 21 | i64::from(id.y)
}

/// The patch of a key, if there is such a patch.
pub(super) fn id(key: i64) -> Option<PatchId> {
    let bits = |from: u32, count: u32| ((key >> from) & ((1 << count) - 1)) as u32;
    let face = Face::new(u8::try_from(key >> 47).ok()?)?;
    PatchId::new(face, bits(42, 5) as u8, bits(21, 21), bits(0, 21))
}

/// Checksum over key and metadata of a row.
pub(super) fn checksum(record: &PatchRecord) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&key(record.id).to_le_bytes());
    hasher.update(&facts::bytes(&record.facts));
    for number in [record.always_awake, record.geometry_bytes, record.texture_bytes] {
        hasher.update(&number.to_le_bytes());
    }
    hasher.finalize()
}

/// The row's record and checksum; the inner error says which patch is damaged and how.
pub(super) fn read(row: &Row) -> rusqlite::Result<Result<(PatchRecord, u32), String>> {
    let stated: i64 = row.get(0)?;
    let address = (row.get::<_, u8>(1)?, row.get::<_, u8>(2)?, row.get::<_, u32>(3)?, row.get::<_, u32>(4)?);
    let Some(id) = Face::new(address.0).and_then(|face| PatchId::new(face, address.1, address.2, address.3)) else {
        return Ok(Err(format!("a row names the patch {address:?}, which does not exist")));
    };
    let record = PatchRecord {
        id,
        facts: facts::of_row(row, FACTS_AT)?,
        always_awake: row.get(AFTER)?,
        geometry_bytes: row.get(AFTER + 2)?,
        texture_bytes: row.get(AFTER + 3)?,
    };
    let (found, expected) = (checksum(&record), row.get::<_, u32>(AFTER + 1)?);
    if stated != key(id) || found != expected {
        return Ok(Err(format!("the row of patch {id} has checksum {found:08x}, expected {expected:08x}")));
    }
    Ok(match facts::check(&record.facts) {
        Ok(()) => Ok((record, found)),
        Err(reason) => Err(format!("the row of patch {id}: {reason}")),
    })
}

/// A row that [`insert`] added or completed.
pub(super) struct Changed {
    /// What the row says now.
    pub(super) record: PatchRecord,
    /// Whether there was none before.
    pub(super) is_new: bool,
}

/// Adds the patches that are not there yet and the parts that rows lack, and returns what changed. Parts that are there stay as they
/// are: a patch has the same bytes whoever built it. So does a damaged row, whose checksum would else be put right.
pub(super) fn insert(connection: &Connection, patches: &[BakedPatch]) -> rusqlite::Result<Vec<Changed>> {
    let mut find = connection.prepare_cached(&format!("SELECT {COLUMNS} FROM patch WHERE key = ?1"))?;
    let mut changed = Vec::new();
    let (mut added, mut combined) = (0, 0);
    for patch in patches {
        match find.query_row([key(patch.record.id)], read).optional()? {
            None => {
                add(connection, patch)?;
                added += 1;
                combined ^= checksum(&patch.record);
                changed.push(Changed { record: patch.record, is_new: true });
            }
            Some(Ok((there, before))) => {
                if let Some(record) = complete(connection, &there, patch)? {
                    combined ^= before ^ checksum(&record);
                    changed.push(Changed { record, is_new: false });
                }
            }
            Some(Err(_)) => {}
        }
    }
    count(connection, added, combined)?;
    Ok(changed)
}

fn add(connection: &Connection, BakedPatch { record, geometry, texture }: &BakedPatch) -> rusqlite::Result<()> {
    let mut statement = connection
        .prepare_cached("INSERT INTO patch VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16,?17,?18,?19)")?;
    let id = record.id;
    let address = [key(id), id.face.index().into(), id.level.into(), id.x.into(), id.y.into()];
    let (facts, stated) = (facts::columns(&record.facts), [record.always_awake, checksum(record)]);
    let address = address.iter().map(|number| number as &dyn ToSql);
    let stated = stated.iter().map(|number| number as &dyn ToSql);
    let values = address.chain(facts.iter().map(|value| value as &dyn ToSql)).chain(stated);
    statement.execute(params_from_iter(values.chain([geometry as &dyn ToSql, texture]))).map(drop)
}

/// Adds to a row the parts that it lacks and the patch has; the record that it has then, if that is another.
fn complete(connection: &Connection, there: &PatchRecord, patch: &BakedPatch) -> rusqlite::Result<Option<PatchRecord>> {
    let geometry = (!there.has_mesh() && patch.record.has_mesh()).then_some(&patch.geometry);
    let texture = (!there.has_texture() && patch.record.has_texture()).then_some(&patch.texture);
    let mut record = *there;
    if geometry.is_some() {
        (record.always_awake, record.geometry_bytes) = (patch.record.always_awake, patch.record.geometry_bytes);
    }
    if texture.is_some() {
        record.texture_bytes = patch.record.texture_bytes;
    }
    if record == *there {
        return Ok(None);
    }
    let mut statement = connection.prepare_cached(
        "UPDATE patch SET always_awake = ?2, checksum = ?3, geometry = coalesce(?4, geometry), texture = coalesce(?5, texture) \
         WHERE key = ?1",
    )?;
    statement.execute(params![key(record.id), record.always_awake, checksum(&record), geometry, texture])?;
    Ok(Some(record))
}

/// Which of the patches are there, whole.
pub(super) fn whole(connection: &Connection, ids: &[PatchId]) -> rusqlite::Result<Vec<PatchId>> {
    let mut statement = connection.prepare_cached(&format!("SELECT 1 FROM patch WHERE key = ?1 AND {WHOLE}"))?;
    let mut found = Vec::with_capacity(ids.len());
    for &id in ids {
        if statement.exists([key(id)])? {
            found.push(id);
        }
    }
    Ok(found)
}

/// Removes a patch.
pub(super) fn remove(connection: &Connection, key: i64) -> rusqlite::Result<()> {
    let mut statement = connection.prepare_cached("DELETE FROM patch WHERE key = ?1 RETURNING checksum")?;
    let combined = statement.query_row([key], |row| row.get(0))?;
    surroundings::remove(connection, key)?;
    count(connection, -1, combined)
}

/// Counts patches added or removed in the tally. SQLite has no exclusive or: a | b less a & b.
fn count(connection: &Connection, patches: i64, combined: u32) -> rusqlite::Result<()> {
    let tally = "UPDATE tally SET patches = patches + ?1, combined = (combined | ?2) - (combined & ?2)";
    connection.execute(tally, params![patches, combined]).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_name_their_patches() {
        for face in Face::ALL {
            for (level, x, y) in [(0, 0, 0), (5, 31, 0), (21, (1 << 21) - 1, (1 << 21) - 2)] {
                let patch = PatchId::new(face, level, x, y);
                assert!(patch.is_some() && patch.map(key).and_then(id) == patch);
            }
        }
        assert_eq!((id(-1), id(7 << 47), id(1)), (None, None, None));
    }
}
