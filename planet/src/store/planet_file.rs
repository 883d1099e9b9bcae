//! A planet file, open: patches in, patches out.
//!
//! Crash safety is SQLite's rollback journal: a transaction is there as a whole or not at all, and the next one to open the
//! file cleans up. Reading and writing may go on at once from several processes; a [`PlanetFile`] itself belongs to one thread
//! at a time, and every reader opens its own.

use super::error::{RecordError, StoreError};
use super::schema::{check_stamp, APPLICATION_ID, FORMAT_VERSION, TABLES};
use super::{geometry, imagery, rows};
use crate::bake::Region;
use crate::lattice::{Lattice, LatticeBox};
use crate::patch::PatchId;
use crate::progressive::PatchMesh;
use crate::recipe::Asset;
use crate::texture::PatchTexture;
use glam::DVec3;
use rusqlite::{params, Connection, ErrorCode, OpenFlags, OptionalExtension, TransactionBehavior};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long to wait for another process to finish a transaction.
const BUSY: Duration = Duration::from_secs(20);

/// Bytes a database page: patches are hundreds of kilobytes, so pages are larger than SQLite's default.
const PAGE_BYTES: u32 = 8192;

/// What a planet file says about its planet.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanetHeader {
    /// Name of the planet.
    pub name: String,
    /// Text of the recipe.
    pub recipe: String,
    /// Files that the recipe names.
    pub assets: Vec<Asset>,
    /// Grid cells along a patch side.
    pub cells: u32,
    /// Lattice of the planet.
    pub lattice: Lattice,
    /// Heights in metres that no point of the terrain lies below or above.
    pub height_range: [f64; 2],
}

/// What is known of a stored patch without reading it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchRecord {
    /// Which patch.
    pub id: PatchId,
    /// Box around all vertices.
    pub bounds: LatticeBox,
    /// Lowest and highest vertex, lattice units above the datum.
    pub heights: [i32; 2],
    /// Largest radial distance in lattice units of the next level's samples from this patch's full grid.
    pub deviation: f64,
    /// Largest own wake of the odd vertices on the parent's boundary, in lattice units.
    pub odd_wake: f64,
    /// Number of vertices that never collapse.
    pub always_awake: u32,
    /// Size of the geometry record.
    pub geometry_bytes: u32,
    /// Size of the texture record.
    pub texture_bytes: u32,
}

/// A patch as it goes into the file.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedPatch {
    /// What the index holds of it.
    pub record: PatchRecord,
    /// Geometry record.
    pub geometry: Vec<u8>,
    /// Texture record.
    pub texture: Vec<u8>,
}

impl BakedPatch {
    /// Encodes a patch. A pure function; the costly part of storing, so it runs on the builder's threads.
    ///
    /// # Errors
    /// For a mesh or texture that breaks the builder's promises.
    pub fn new(mesh: &PatchMesh, texture: &PatchTexture) -> Result<BakedPatch, RecordError> {
        let geometry = geometry::encode(mesh)?;
        let texture = imagery::encode(texture, mesh.id, mesh.cells)?;
        let record = PatchRecord {
            id: mesh.id,
            bounds: mesh.bounds,
            heights: mesh.heights,
            deviation: mesh.deviation,
            odd_wake: mesh.odd_wake,
            always_awake: mesh.always_awake() as u32,
            geometry_bytes: geometry.len() as u32,
            texture_bytes: texture.len() as u32,
        };
        Ok(BakedPatch { record, geometry, texture })
    }
}

/// An open planet file.
#[derive(Debug)]
pub struct PlanetFile {
    connection: Connection,
    path: PathBuf,
    header: PlanetHeader,
    writable: bool,
}

impl PlanetFile {
    /// Opens a file for adding patches of the planet that `header` describes; makes it if there is none.
    ///
    /// # Errors
    /// If the path cannot be written, or holds anything but a sound planet file of the same planet and grid.
    pub fn create_or_resume(path: &Path, header: &PlanetHeader) -> Result<PlanetFile, StoreError> {
        if !path.exists() {
            create(path, header)?;
        }
        check_stamp(path)?;
        let file = PlanetFile::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE, true)?;
        file.check_same(header)?;
        Ok(file)
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
        let header = read_header(&connection, path)?;
        Ok(PlanetFile { connection, path: path.to_owned(), header, writable })
    }

    /// What the file says about its planet.
    pub fn header(&self) -> &PlanetHeader {
        &self.header
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All patches, coarse to fine, without their blobs.
    ///
    /// # Errors
    /// If any row is damaged, or if rows are missing.
    pub fn index(&self) -> Result<Vec<PatchRecord>, StoreError> {
        let failed = |source| failure(&self.path, "read the patch index", source);
        // One transaction, so that rows and tally are of one moment.
        let moment = self.connection.unchecked_transaction().map_err(failed)?;
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

    /// Ids of all patches in the file.
    ///
    /// # Errors
    /// As [`PlanetFile::index`].
    pub fn ids(&self) -> Result<HashSet<PatchId>, StoreError> {
        Ok(self.index()?.into_iter().map(|r| r.id).collect())
    }

    /// Whether the file holds a patch.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn contains(&self, id: PatchId) -> Result<bool, StoreError> {
        let found =
            self.connection.prepare_cached("SELECT 1 FROM patch WHERE key = ?1").and_then(|mut s| s.exists([rows::key(id)]));
        found.map_err(|source| failure(&self.path, "look up a patch", source))
    }

    /// A patch's mesh.
    ///
    /// # Errors
    /// If the patch is not in the file, or damaged.
    pub fn mesh(&self, id: PatchId) -> Result<PatchMesh, StoreError> {
        geometry::decode(&self.geometry_record(id)?, id, self.header.cells)
            .map_err(|source| self.damaged_patch(id, "geometry", source))
    }

    /// A patch's texture.
    ///
    /// # Errors
    /// If the patch is not in the file, or damaged.
    pub fn texture(&self, id: PatchId) -> Result<PatchTexture, StoreError> {
        imagery::decode(&self.texture_record(id)?, id, self.header.cells)
            .map_err(|source| self.damaged_patch(id, "texture", source))
    }

    /// A patch's geometry record as it is stored.
    ///
    /// # Errors
    /// If the patch is not in the file.
    pub fn geometry_record(&self, id: PatchId) -> Result<Vec<u8>, StoreError> {
        self.blob(id, "SELECT geometry FROM patch WHERE key = ?1")
    }

    /// A patch's texture record as it is stored.
    ///
    /// # Errors
    /// If the patch is not in the file.
    pub fn texture_record(&self, id: PatchId) -> Result<Vec<u8>, StoreError> {
        self.blob(id, "SELECT texture FROM patch WHERE key = ?1")
    }

    fn blob(&self, id: PatchId, query: &str) -> Result<Vec<u8>, StoreError> {
        let failed = |source| failure(&self.path, "read a patch", source);
        let mut statement = self.connection.prepare_cached(query).map_err(failed)?;
        let blob = statement.query_row([rows::key(id)], |row| row.get(0)).optional().map_err(failed)?;
        blob.ok_or_else(|| StoreError::Absent { file: self.path.clone(), id })
    }

    /// Adds patches, all or none of them. Patches that the file holds already stay as they are: they are the same.
    ///
    /// # Errors
    /// If the file was opened for reading, or cannot be written.
    pub fn put(&mut self, patches: &[BakedPatch]) -> Result<(), StoreError> {
        self.transaction("add patches", |connection| {
            let mut statement = connection.prepare_cached(
                "INSERT OR IGNORE INTO patch VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16,?17,?18,?19)",
            )?;
            let (mut added, mut combined) = (0i64, 0u32);
            for BakedPatch { record, geometry, texture } in patches {
                let (id, low, high) = (record.id, record.bounds.low, record.bounds.high);
                let checksum = rows::checksum(record);
                let values = params![
                    rows::key(id),
                    id.face.index(),
                    id.level,
                    id.x,
                    id.y,
                    low.x,
                    low.y,
                    low.z,
                    high.x,
                    high.y,
                    high.z,
                    record.heights[0],
                    record.heights[1],
                    record.deviation,
                    record.odd_wake,
                    record.always_awake,
                    checksum,
                    geometry,
                    texture
                ];
                if statement.execute(values)? == 1 {
                    added += 1;
                    combined ^= checksum;
                }
            }
            // SQLite has no exclusive or: a | b less a & b.
            let tally = "UPDATE tally SET patches = patches + ?1, combined = (combined | ?2) - (combined & ?2)";
            connection.execute(tally, params![added, combined]).map(drop)
        })
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
        work(&transaction).map_err(failed)?;
        transaction.commit().map_err(failed)
    }

    fn check_same(&self, expected: &PlanetHeader) -> Result<(), StoreError> {
        let found = &self.header;
        let size = |assets: &[Asset]| {
            assets.iter().map(|a| format!("{} ({} bytes)", a.name, a.bytes.len())).collect::<Vec<_>>().join(", ")
        };
        let range = |h: &PlanetHeader| format!("{:?} m", h.height_range);
        let lattice = |h: &PlanetHeader| format!("unit {} m, radius {} units", h.lattice.unit, h.lattice.radius);
        let text = |h: &PlanetHeader| {
            format!("'{}', {} bytes, checksum {:08x}", h.name, h.recipe.len(), crc32fast::hash(h.recipe.as_bytes()))
        };
        let differs = [
            (found.cells != expected.cells, "cells along a patch side", found.cells.to_string(), expected.cells.to_string()),
            (found.recipe != expected.recipe || found.name != expected.name, "the recipe", text(found), text(expected)),
            (found.assets != expected.assets, "the recipe's files", size(&found.assets), size(&expected.assets)),
            (found.lattice != expected.lattice, "the lattice", lattice(found), lattice(expected)),
            (found.height_range != expected.height_range, "the height range", range(found), range(expected)),
        ];
        match differs.into_iter().find(|d| d.0) {
            None => Ok(()),
            Some((_, what, found, expected)) => Err(StoreError::Differs { file: self.path.clone(), what, found, expected }),
        }
    }

    fn damaged(&self, what: String) -> StoreError {
        StoreError::Damaged { file: self.path.clone(), what }
    }

    fn damaged_patch(&self, id: PatchId, part: &'static str, source: RecordError) -> StoreError {
        StoreError::DamagedPatch { file: self.path.clone(), id, part, source }
    }
}

/// Makes an empty planet file beside `path` and moves it there when it is complete, so that `path` never holds half a file.
fn create(path: &Path, header: &PlanetHeader) -> Result<(), StoreError> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let draft = PathBuf::from(name);
    let system = |action| move |source| StoreError::System { file: path.to_owned(), action, source };
    std::fs::File::create(&draft).map_err(system("create the planet file"))?;
    let written = write_header(&draft, header).map_err(|source| failure(path, "write the planet file", source));
    let moved = written.and_then(|()| std::fs::rename(&draft, path).map_err(system("move the new planet file into place")));
    if moved.is_err() {
        // The first error is the one to report; a draft left behind is overwritten by the next attempt.
        let _ = std::fs::remove_file(&draft);
    }
    moved
}

fn write_header(draft: &Path, header: &PlanetHeader) -> rusqlite::Result<()> {
    let mut connection = Connection::open_with_flags(draft, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
    connection.pragma_update(None, "page_size", PAGE_BYTES)?;
    connection.pragma_update(None, "application_id", APPLICATION_ID)?;
    connection.pragma_update(None, "user_version", FORMAT_VERSION)?;
    let transaction = connection.transaction()?;
    transaction.execute_batch(TABLES)?;
    let (lattice, [lowest, highest]) = (header.lattice, header.height_range);
    let checksum = header_checksum(header, crate::KAPPA, crate::DEVIATION_SHARE);
    transaction.execute(
        "INSERT INTO planet VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
        params![
            header.name,
            header.recipe,
            header.cells,
            crate::KAPPA,
            crate::DEVIATION_SHARE,
            lattice.unit,
            lattice.radius,
            lowest,
            highest,
            checksum
        ],
    )?;
    for (place, asset) in header.assets.iter().enumerate() {
        transaction.execute("INSERT INTO asset VALUES (?1, ?2, ?3)", params![place as i64, asset.name, asset.bytes])?;
    }
    transaction.commit()?;
    connection.close().map_err(|(_, source)| source)
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(BUSY)?;
    connection.pragma_update(None, "trusted_schema", false)?;
    connection.pragma_update(None, "cell_size_check", true)
}

fn header_checksum(header: &PlanetHeader, kappa: f64, deviation_share: f64) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(header.name.as_bytes());
    add(header.recipe.as_bytes());
    for asset in &header.assets {
        add(asset.name.as_bytes());
        add(&asset.bytes);
    }
    add(&header.cells.to_le_bytes());
    let [lowest, highest] = header.height_range;
    for number in [kappa, deviation_share, header.lattice.unit, header.lattice.radius, lowest, highest] {
        add(&number.to_le_bytes());
    }
    hasher.finalize()
}

fn read_header(connection: &Connection, path: &Path) -> Result<PlanetHeader, StoreError> {
    let failed = |source| failure(path, "read the planet's description", source);
    let damaged = |what: String| StoreError::Damaged { file: path.to_owned(), what };
    let moment = connection.unchecked_transaction().map_err(failed)?;
    check_length(&moment, path)?;
    let query = "SELECT name, recipe, cells, kappa, deviation_share, lattice_unit, lattice_radius, lowest_m, highest_m, checksum FROM planet";
    let read = |row: &rusqlite::Row| {
        let header = PlanetHeader {
            name: row.get(0)?,
            recipe: row.get(1)?,
            assets: Vec::new(),
            cells: row.get(2)?,
            lattice: Lattice { unit: row.get(5)?, radius: row.get(6)? },
            height_range: [row.get(7)?, row.get(8)?],
        };
        Ok((header, row.get::<_, f64>(3)?, row.get::<_, f64>(4)?, row.get::<_, u32>(9)?))
    };
    let (mut header, kappa, share, expected) = moment.query_row(query, [], read).map_err(failed)?;
    let asset = |row: &rusqlite::Row| Ok(Asset { name: row.get(0)?, bytes: row.get(1)? });
    let mut statement = moment.prepare("SELECT name, bytes FROM asset ORDER BY place").map_err(failed)?;
    header.assets = statement.query_map([], asset).and_then(Iterator::collect).map_err(failed)?;
    let found = header_checksum(&header, kappa, share);
    if found != expected {
        return Err(damaged(format!("the planet's description has checksum {found:08x}, expected {expected:08x}")));
    }
    if !geometry::cells_are_valid(header.cells) {
        return Err(damaged(format!("{} cells along a patch side", header.cells)));
    }
    if (kappa, share) != (crate::KAPPA, crate::DEVIATION_SHARE) {
        let expected = format!("{} with share {}", crate::KAPPA, crate::DEVIATION_SHARE);
        let found = format!("{kappa} with share {share}");
        return Err(StoreError::Differs { file: path.to_owned(), what: "the coarsest tolerance", found, expected });
    }
    Ok(header)
}

/// Refuses a file that is shorter than its own page count; within a transaction, so that no writer is half way.
fn check_length(moment: &Connection, path: &Path) -> Result<(), StoreError> {
    let failed = |source| failure(path, "read the planet's description", source);
    // Any read takes the lock.
    moment.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(())).map_err(failed)?;
    let number = |name: &str| moment.pragma_query_value(None, name, |row| row.get::<_, i64>(0)).map_err(failed);
    let expected = number("page_count")?.saturating_mul(number("page_size")?);
    let length = std::fs::metadata(path).map_err(|source| StoreError::System {
        file: path.to_owned(),
        action: "measure the planet file",
        source,
    })?;
    if (length.len() as i64) < expected {
        let what = format!("cut short: {} bytes, expected {expected}", length.len());
        return Err(StoreError::Damaged { file: path.to_owned(), what });
    }
    Ok(())
}

/// Sorts SQLite's errors: those that damage explains, and those of the system around the file.
fn failure(path: &Path, action: &'static str, source: rusqlite::Error) -> StoreError {
    use rusqlite::ffi::SQLITE_IOERR_SHORT_READ;
    let damage = match &source {
        rusqlite::Error::SqliteFailure(error, _) => {
            let damaged = matches!(
                error.code,
                ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase | ErrorCode::Unknown | ErrorCode::TooBig
            );
            damaged || error.extended_code == SQLITE_IOERR_SHORT_READ
        }
        rusqlite::Error::SqlInputError { .. } | rusqlite::Error::QueryReturnedNoRows => true,
        rusqlite::Error::InvalidColumnType(..)
        | rusqlite::Error::IntegralValueOutOfRange(..)
        | rusqlite::Error::Utf8Error(..) => true,
        rusqlite::Error::FromSqlConversionFailure(..) => true,
        _ => false,
    };
    if damage {
        StoreError::Damaged { file: path.to_owned(), what: format!("cannot {action}: {source}") }
    } else {
        StoreError::Database { file: path.to_owned(), action, source }
    }
}
