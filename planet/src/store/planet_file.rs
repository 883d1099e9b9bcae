//! A planet file, open: patches in, patches out.
//!
//! Crash safety is SQLite's rollback journal: a transaction is there as a whole or not at all, and the next one to open the
//! file cleans up. Reading and writing may go on at once from several processes; a [`PlanetFile`] itself belongs to one thread
//! at a time, and every reader opens its own. When the ground is edited meanwhile, all patches are absent to those who opened the file
//! before, and they can write none: what they know and build is of the ground before.

use super::baked::{BakedPatch, PatchRecord};
use super::error::{failure, RecordError, StoreError};
use super::header;
use super::header::PlanetHeader;
use super::records::{self, Part};
use super::schema::check_stamp;
use super::surroundings::SurroundingsRecord;
use super::Region;
use super::{cached, geometry, imagery, maps, pending, rows, surroundings};
use crate::globe::patch::PatchId;
use crate::ground::texture::PatchTexture;
use crate::mesh::progressive::{PatchFacts, PatchMesh};
use glam::DVec3;
use rusqlite::{params, Connection, ErrorCode, OpenFlags, OptionalExtension, TransactionBehavior, MAIN_DB};
use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long to wait for another process to finish a transaction.
const BUSY: Duration = Duration::from_secs(20);

/// An open planet file.
#[derive(Debug)]
pub struct PlanetFile {
    connection: Connection,
    path: PathBuf,
    header: PlanetHeader,
    /// The header's seal: in the file it changes when the ground is edited.
    checksum: u32,
    writable: bool,
}

impl PlanetFile {
    /// Opens a file for adding patches of the planet that `header` describes; makes it if there is none. A file with other places gets
    /// those of `header`, if it can be written.
    ///
    /// # Errors
    /// If the path cannot be written, or holds anything but a sound planet file of the same planet and grid.
    pub fn create_or_resume(path: &Path, header: &PlanetHeader) -> Result<PlanetFile, StoreError> {
        if !path.exists() {
            header::create(path, header)?;
        }
        check_stamp(path)?;
        let mut file = PlanetFile::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE, true)?;
        header::check_same(path, &file.header, header)?;
        if file.header.recipe != header.recipe {
            match file.transaction("change the places", |connection| header::replace(connection, header)) {
                Ok(()) => {
                    file.header.recipe.clone_from(&header.recipe);
                    file.checksum = header.seal();
                }
                Err(error) => tracing::warn!(%error, file = %path.display(), "the places of the recipe are not kept"),
            }
        }
        Ok(file)
    }

    /// Opens a file that there is, to change it.
    ///
    /// # Errors
    /// As [`PlanetFile::open`], and if the file is marked read-only.
    pub fn open_to_edit(path: &Path) -> Result<PlanetFile, StoreError> {
        check_stamp(path)?;
        let system = |source| StoreError::System { file: path.to_owned(), action: "open the planet file for writing", source };
        if std::fs::metadata(path).map_err(system)?.permissions().readonly() {
            // SQLite would open it, and refuse the first change without saying why.
            return Err(system(std::io::Error::new(std::io::ErrorKind::PermissionDenied, "the file is read-only")));
        }
        PlanetFile::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE, true)
    }

    /// Opens a file for reading.
    ///
    /// # Errors
    /// If there is no such file, or if it is not a sound planet file of this format version.
    pub fn open(path: &Path) -> Result<PlanetFile, StoreError> {
        check_stamp(path)?;
        match PlanetFile::connect(path, OpenFlags::SQLITE_OPEN_READ_ONLY, false) {
            // A bake was killed: its journal can only be rolled back by a connection that may write.
            Err(StoreError::Database { source, .. }) if source.sqlite_error_code() == Some(ErrorCode::ReadOnly) => {
                PlanetFile::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE, false)
            }
            other => other,
        }
    }

    fn connect(path: &Path, access: OpenFlags, writable: bool) -> Result<PlanetFile, StoreError> {
        let failed = |source| failure(path, "open the planet file", source);
        let connection = Connection::open_with_flags(path, access | OpenFlags::SQLITE_OPEN_NO_MUTEX).map_err(failed)?;
        prepare(&connection).map_err(failed)?;
        let header = header::read(&connection, path)?;
        let checksum = header.seal();
        Ok(PlanetFile { connection, path: path.to_owned(), header, checksum, writable })
    }

    /// What the file says about its planet.
    pub fn header(&self) -> &PlanetHeader {
        &self.header
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All patches, coarse to fine, without their blobs; also those that lack their mesh, or mesh and texture.
    ///
    /// # Errors
    /// If any row is damaged, or if rows are missing.
    pub fn index(&self) -> Result<Vec<PatchRecord>, StoreError> {
        let failed = |source| failure(&self.path, "read the patch index", source);
        // One transaction, so that rows and tally are of one moment.
        let moment = self.connection.unchecked_transaction().map_err(failed)?;
        if !self.is_current().map_err(failed)? {
            return Err(StoreError::Changed { file: self.path.clone() });
        }
        let mut statement = moment.prepare_cached(&format!("SELECT {} FROM patch", rows::COLUMNS)).map_err(failed)?;
        let mut records = Vec::new();
        let mut combined = 0;
        for row in statement.query_map([], rows::read).map_err(failed)? {
            let (record, checksum) = row.map_err(failed)?.map_err(|what| self.damaged(what))?;
            combined ^= checksum;
            records.push(record);
        }
        let tally =
            moment.query_row("SELECT patches, combined FROM tally", [], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, u32>(1)?)));
        let (patches, expected) = tally.map_err(failed)?;
        if patches != records.len() as i64 || combined != expected {
            let found = format!("{} patches with checksum {combined:08x}", records.len());
            return Err(self.damaged(format!("the index has {found}, expected {patches} with {expected:08x}")));
        }
        records.sort_by_key(|r| (r.id.level, r.id.face, r.id.y, r.id.x));
        Ok(records)
    }

    /// Ids of all patches in the file that have mesh and texture.
    ///
    /// # Errors
    /// As [`PlanetFile::index`].
    pub fn ids(&self) -> Result<HashSet<PatchId>, StoreError> {
        Ok(self.index()?.into_iter().filter(PatchRecord::is_whole).map(|r| r.id).collect())
    }

    /// Whether the file holds a patch's mesh, of the ground that it was opened with.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn contains(&self, id: PatchId) -> Result<bool, StoreError> {
        self.has(id, "SELECT 1 FROM patch, planet WHERE key = ?1 AND planet.checksum = ?2 AND length(geometry) > 0")
    }

    /// Whether the file holds a patch's texture, of the ground that it was opened with.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn contains_texture(&self, id: PatchId) -> Result<bool, StoreError> {
        self.has(id, "SELECT 1 FROM patch, planet WHERE key = ?1 AND planet.checksum = ?2 AND length(texture) > 0")
    }

    /// What the file knows of a patch of the ground that it was opened with, whether its mesh is there or not.
    ///
    /// # Errors
    /// If the file cannot be read, or the patch's row is damaged.
    pub fn facts(&self, id: PatchId) -> Result<Option<PatchFacts>, StoreError> {
        let failed = |source| failure(&self.path, "look up a patch", source);
        let columns = rows::COLUMNS;
        let query =
            format!("SELECT {columns} FROM patch WHERE key = ?1 AND EXISTS (SELECT 1 FROM planet WHERE planet.checksum = ?2)");
        let mut statement = self.connection.prepare_cached(&query).map_err(failed)?;
        let row = statement.query_row(params![rows::key(id), self.checksum], rows::read).optional().map_err(failed)?;
        row.map(|row| row.map(|(record, _)| record.facts).map_err(|what| self.damaged(what))).transpose()
    }

    fn has(&self, id: PatchId, query: &str) -> Result<bool, StoreError> {
        let found = self.connection.prepare_cached(query).and_then(|mut s| s.exists(params![rows::key(id), self.checksum]));
        found.map_err(|source| failure(&self.path, "look up a patch", source))
    }

    /// A patch's mesh.
    ///
    /// # Errors
    /// If it is not in the file, or damaged.
    pub fn mesh(&self, id: PatchId) -> Result<PatchMesh, StoreError> {
        geometry::decode(&self.geometry_record(id)?, id, self.header.cells)
            .map_err(|source| self.damaged_patch(id, "geometry", source))
    }

    /// A patch's texture.
    ///
    /// # Errors
    /// If it is not in the file, or damaged.
    pub fn texture(&self, id: PatchId) -> Result<PatchTexture, StoreError> {
        imagery::decode(&self.texture_record(id)?, id, self.header.cells)
            .map_err(|source| self.damaged_patch(id, "texture", source))
    }

    /// Heights around a patch, as [`sample_surroundings`](crate::ground::surroundings::sample_surroundings) gives them, if the file has them.
    ///
    /// # Errors
    /// If the file cannot be read, or they are damaged.
    pub fn surroundings(&self, id: PatchId) -> Result<Option<Vec<i32>>, StoreError> {
        records::surroundings(self, id)
    }

    /// The map of the planet's clouds of `side` texels a side, if the file has it.
    ///
    /// # Errors
    /// If the file cannot be read, or the map is damaged.
    pub fn cloud_map(&self, side: usize) -> Result<Option<Vec<u8>>, StoreError> {
        records::cloud_map(self, side)
    }

    /// The record of the map of the planet's clouds.
    pub(super) fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError> {
        let record = maps::read(&self.connection, maps::CLOUDS);
        record.map_err(|source| failure(&self.path, "read the map of clouds", source))
    }

    /// Keeps the map of the planet's clouds.
    ///
    /// # Errors
    /// If the file was opened for reading, or cannot be written.
    pub fn keep_cloud_map(&mut self, texels: &[u8], side: usize) -> Result<(), StoreError> {
        let record = maps::encode(texels, side);
        self.transaction("keep the map of clouds", |connection| maps::write(connection, maps::CLOUDS, &record))
    }

    /// A patch's geometry record as it is stored.
    ///
    /// # Errors
    /// If there is none in the file.
    pub fn geometry_record(&self, id: PatchId) -> Result<Vec<u8>, StoreError> {
        self.blob(id, "SELECT geometry FROM patch, planet WHERE key = ?1 AND planet.checksum = ?2 AND length(geometry) > 0")
    }

    /// A patch's texture record as it is stored.
    ///
    /// # Errors
    /// If there is none in the file.
    pub fn texture_record(&self, id: PatchId) -> Result<Vec<u8>, StoreError> {
        self.blob(id, "SELECT texture FROM patch, planet WHERE key = ?1 AND planet.checksum = ?2 AND length(texture) > 0")
    }

    /// Bytes of a record, as far as it has them. No more of the file is read than where they lie.
    pub(super) fn record_bytes(&self, id: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError> {
        let failed = |source| failure(&self.path, "read a patch", source);
        let (table, column) = match part {
            Part::Geometry => ("patch", "geometry"),
            Part::Texture => ("patch", "texture"),
            Part::Surroundings => ("surroundings", "heights"),
        };
        // One transaction, so that the record is there and of this ground until it is read.
        let moment = self.connection.unchecked_transaction().map_err(failed)?;
        let query = format!("SELECT length({column}) FROM {table}, planet WHERE key = ?1 AND planet.checksum = ?2");
        let mut statement = moment.prepare_cached(&query).map_err(failed)?;
        let length = statement.query_row(params![rows::key(id), self.checksum], |row| row.get::<_, i64>(0)).optional();
        let Some(length) = length.map_err(failed)?.filter(|&length| length > 0) else { return Ok(None) };
        let blob = moment.blob_open(MAIN_DB, table, column, rows::key(id), true).map_err(failed)?;
        let end = range.end.min(length as usize);
        let mut bytes = vec![0; end.saturating_sub(range.start)];
        blob.read_at_exact(&mut bytes, range.start).map_err(failed)?;
        Ok(Some(bytes))
    }

    fn blob(&self, id: PatchId, query: &str) -> Result<Vec<u8>, StoreError> {
        let failed = |source| failure(&self.path, "read a patch", source);
        let mut statement = self.connection.prepare_cached(query).map_err(failed)?;
        let blob = statement.query_row(params![rows::key(id), self.checksum], |row| row.get(0)).optional().map_err(failed)?;
        match blob {
            Some(blob) => Ok(blob),
            None if self.is_current().map_err(failed)? => Err(StoreError::Absent { file: self.path.clone(), id }),
            None => Err(StoreError::Changed { file: self.path.clone() }),
        }
    }

    /// Whether the file still says of its planet what it said when it was opened.
    fn is_current(&self) -> rusqlite::Result<bool> {
        let found: u32 = self.connection.prepare_cached("SELECT checksum FROM planet")?.query_row([], |row| row.get(0))?;
        Ok(found == self.checksum)
    }

    /// Patches that an edit of the ground removed and that were not built again yet, coarse to fine: the file is unfinished while there
    /// are any.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged.
    pub fn pending(&self) -> Result<Vec<PatchId>, StoreError> {
        let found = pending::list(&self.connection).map_err(|source| failure(&self.path, "read the pending patches", source))?;
        let ids: Option<Vec<PatchId>> = found.into_iter().collect();
        let mut ids = ids.ok_or_else(|| self.damaged("a pending patch does not exist".into()))?;
        ids.sort_by_key(|id| (id.level, id.face, id.y, id.x));
        Ok(ids)
    }

    /// Puts another ground in place of the file's, all or nothing: its header (of the same planet, grid and lattice); all patches that
    /// are touched go, to be pending unless they were only cached or lacked a part; so do the surroundings of those that are `touched_around`; and `built` patches are back at once, with what is `around` them. Returns how many are touched.
    /// They are found within the transaction: a flight may add patches until it begins, and none of the ground before from then on.
    ///
    /// # Errors
    /// If the file was opened for reading, cannot be written, or was edited meanwhile.
    pub fn replace_ground(
        &mut self,
        header: &PlanetHeader,
        [touched, touched_around]: [&dyn Fn(PatchId) -> bool; 2],
        built: &[BakedPatch],
        around: &[SurroundingsRecord],
    ) -> Result<usize, StoreError> {
        let mut removed = 0;
        self.transaction("edit the ground", |connection| {
            header::replace(connection, header)?;
            removed = pending::put_off(connection, touched)?;
            surroundings::forget(connection, touched_around)?;
            rows::insert(connection, built)?;
            surroundings::insert(connection, around)?;
            pending::done(connection, built.iter().filter(|p| p.record.is_whole()).map(|p| p.record.id))
        })?;
        self.header = header.clone();
        self.checksum = header.seal();
        Ok(removed)
    }

    /// Adds patches, all or none of them, to stay. Parts that the file holds already are the same and stay as they are, those that it
    /// lacks are added; patches that were only cached are kept from now on.
    ///
    /// # Errors
    /// If the file was opened for reading, or cannot be written.
    pub fn put(&mut self, patches: &[BakedPatch]) -> Result<(), StoreError> {
        self.put_with(patches, &[])
    }

    /// [`PlanetFile::put`], and heights around patches.
    ///
    /// # Errors
    /// As [`PlanetFile::put`].
    pub fn put_with(&mut self, patches: &[BakedPatch], around: &[SurroundingsRecord]) -> Result<(), StoreError> {
        self.transaction("add patches", |connection| {
            rows::insert(connection, patches)?;
            surroundings::insert(connection, around)?;
            cached::keep(connection, patches.iter().map(|p| p.record.id))?;
            pending::done(connection, patches.iter().filter(|p| p.record.is_whole()).map(|p| p.record.id))
        })
    }

    /// Keeps patches that the file holds already, whole, even if they were only cached.
    ///
    /// # Errors
    /// As [`PlanetFile::put`].
    pub fn keep(&mut self, ids: &[PatchId]) -> Result<(), StoreError> {
        self.transaction("keep patches", |connection| {
            let whole = rows::whole(connection, ids)?;
            cached::keep(connection, whole.iter().copied())?;
            pending::done(connection, whole.into_iter())
        })
    }

    /// Adds patches, or parts of them, that may go again (not those of patches that stay), and heights around patches of the file, notes when patches were used (any count that grows), and removes those unused for longest until
    /// all that may go hold at most `budget` bytes. All or nothing.
    ///
    /// # Errors
    /// As [`PlanetFile::put`].
    pub fn cache(
        &mut self,
        patches: &[BakedPatch],
        around: &[SurroundingsRecord],
        used: &[PatchId],
        now: i64,
        budget: u64,
    ) -> Result<(), StoreError> {
        self.transaction("cache patches", |connection| {
            let changed = rows::insert(connection, patches)?;
            cached::add(connection, &changed, now)?;
            surroundings::insert(connection, around)?;
            cached::touch(connection, used, now)?;
            cached::evict(connection, budget)
        })
    }

    /// Bytes of the patches that may go again.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn cached_bytes(&self) -> Result<u64, StoreError> {
        cached::bytes(&self.connection).map_err(|source| failure(&self.path, "measure the cache", source))
    }

    /// Regions that were asked to be finer than the rest, in the order of asking.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn regions(&self) -> Result<Vec<Region>, StoreError> {
        let failed = |source| failure(&self.path, "read the regions", source);
        let read = |row: &rusqlite::Row| {
            let direction = DVec3::new(row.get(0)?, row.get(1)?, row.get(2)?);
            Ok(Region { direction, radius_m: row.get(3)?, to_level: row.get(4)? })
        };
        let mut statement =
            self.connection.prepare("SELECT x, y, z, radius_m, to_level FROM region ORDER BY rowid").map_err(failed)?;
        let regions = statement.query_map([], read).and_then(Iterator::collect).map_err(failed);
        regions
    }

    /// Notes that a region was asked to be finer than the rest.
    ///
    /// # Errors
    /// If the file was opened for reading, or cannot be written.
    pub fn note_region(&mut self, region: &Region) -> Result<(), StoreError> {
        let d = region.direction;
        self.transaction("note a region", |connection| {
            let values = params![d.x, d.y, d.z, region.radius_m, region.to_level];
            connection.execute("INSERT OR IGNORE INTO region VALUES (?1, ?2, ?3, ?4, ?5)", values).map(drop)
        })
    }

    fn transaction(
        &mut self,
        action: &'static str,
        work: impl FnOnce(&Connection) -> rusqlite::Result<()>,
    ) -> Result<(), StoreError> {
        if !self.writable {
            return Err(StoreError::ReadOnly { file: self.path.clone() });
        }
        let path = &self.path;
        let failed = |source| failure(path, action, source);
        let transaction = self.connection.transaction_with_behavior(TransactionBehavior::Immediate).map_err(failed)?;
        let found: u32 = transaction.query_row("SELECT checksum FROM planet", [], |row| row.get(0)).map_err(failed)?;
        if found != self.checksum {
            return Err(StoreError::Changed { file: path.clone() });
        }
        work(&transaction).map_err(failed)?;
        transaction.commit().map_err(failed)
    }

    fn damaged(&self, what: String) -> StoreError {
        StoreError::Damaged { file: self.path.clone(), what }
    }

    fn damaged_patch(&self, id: PatchId, part: &'static str, source: RecordError) -> StoreError {
        StoreError::DamagedPatch { file: self.path.clone(), id, part, source }
    }
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(BUSY)?;
    connection.pragma_update(None, "trusted_schema", false)?;
    connection.pragma_update(None, "cell_size_check", true)
}
