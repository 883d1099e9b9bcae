//! What a planet file says about its planet: written when the file is made and when its ground is edited, and checked whenever it is
//! opened.

use super::error::{failure, StoreError};
use super::geometry;
use super::schema::{APPLICATION_ID, FORMAT_VERSION, TABLES};
use crate::globe::lattice::Lattice;
use crate::recipe::{ground_text, Asset};
use rusqlite::{params, Connection, OpenFlags};
use std::path::{Path, PathBuf};

/// Bytes a database page: patches are hundreds of kilobytes, so pages are larger than SQLite's default.
const PAGE_BYTES: u32 = 8192;

/// What the builder takes as given: the coarsest tolerance, and the deviation's share of it.
const BUILDER: [f64; 2] = [crate::mesh::certificate::KAPPA, crate::mesh::certificate::DEVIATION_SHARE];

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

impl PlanetHeader {
    /// Bytes that it takes, about.
    pub fn bytes(&self) -> usize {
        let assets = self.assets.iter().map(|asset| asset.name.len() + asset.bytes.len());
        self.name.len() + self.recipe.len() + assets.sum::<usize>() + 64
    }

    /// A name for its file that says which planet it is, and differs for every recipe and grid.
    pub fn file_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
        let name: String = self.name.chars().map(plain).collect();
        format!("{name}-{:08x}.planet", self.checksum())
    }

    /// Checksum over all of it but the recipe's places, which decide nothing, and over what the builder takes as given.
    pub fn checksum(&self) -> u32 {
        header_checksum(self, &ground_text(&self.recipe), BUILDER)
    }

    /// Checksum over all of it, with which a file is sealed.
    pub(super) fn seal(&self) -> u32 {
        header_checksum(self, &self.recipe, BUILDER)
    }
}

/// Makes an empty planet file beside `path` and moves it there when it is complete, so that `path` never holds half a file.
pub(super) fn create(path: &Path, header: &PlanetHeader) -> Result<(), StoreError> {
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
    let checksum = header.seal();
    transaction.execute(
        "INSERT INTO planet VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
        params![
            header.name,
            header.recipe,
            header.cells,
            crate::mesh::certificate::KAPPA,
            crate::mesh::certificate::DEVIATION_SHARE,
            lattice.unit,
            lattice.radius,
            lowest,
            highest,
            checksum
        ],
    )?;
    for (index, asset) in header.assets.iter().enumerate() {
        transaction.execute("INSERT INTO asset VALUES (?1, ?2, ?3)", params![index as i64, asset.name, asset.bytes])?;
    }
    transaction.commit()?;
    connection.close().map_err(|(_, source)| source)
}

/// Puts another recipe and its height range in place of those in the file; all else stays.
pub(super) fn replace(connection: &Connection, header: &PlanetHeader) -> rusqlite::Result<()> {
    let [lowest, highest] = header.height_range;
    let values = params![header.recipe, lowest, highest, header.seal()];
    connection.execute("UPDATE planet SET recipe = ?1, lowest_m = ?2, highest_m = ?3, checksum = ?4", values).map(drop)
}

fn header_checksum(header: &PlanetHeader, recipe: &str, builder: [f64; 2]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(header.name.as_bytes());
    add(recipe.as_bytes());
    for asset in &header.assets {
        add(asset.name.as_bytes());
        add(&asset.bytes);
    }
    add(&header.cells.to_le_bytes());
    let [lowest, highest] = header.height_range;
    for number in builder.into_iter().chain([header.lattice.unit, header.lattice.radius, lowest, highest]) {
        add(&number.to_le_bytes());
    }
    hasher.finalize()
}

/// Reads and checks what a file says about its planet.
pub(super) fn read(connection: &Connection, path: &Path) -> Result<PlanetHeader, StoreError> {
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
    let found = header_checksum(&header, &header.recipe, [kappa, share]);
    if found != expected {
        return Err(damaged(format!("the planet's description has checksum {found:08x}, expected {expected:08x}")));
    }
    if !geometry::cells_are_valid(header.cells) {
        return Err(damaged(format!("{} cells along a patch side", header.cells)));
    }
    if [kappa, share] != BUILDER {
        let expected = format!("{} with share {}", BUILDER[0], BUILDER[1]);
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

/// Refuses a file that was baked from anything else. Places may differ.
pub(super) fn check_same(path: &Path, found: &PlanetHeader, expected: &PlanetHeader) -> Result<(), StoreError> {
    let size =
        |assets: &[Asset]| assets.iter().map(|a| format!("{} ({} bytes)", a.name, a.bytes.len())).collect::<Vec<_>>().join(", ");
    let range = |h: &PlanetHeader| format!("{:?} m", h.height_range);
    let lattice = |h: &PlanetHeader| format!("unit {} m, radius {} units", h.lattice.unit, h.lattice.radius);
    let text = |h: &PlanetHeader| {
        format!("'{}', {} bytes, checksum {:08x}", h.name, h.recipe.len(), crc32fast::hash(h.recipe.as_bytes()))
    };
    let (found_text, expected_text) = (ground_text(&found.recipe), ground_text(&expected.recipe));
    let differs = [
        (found.cells != expected.cells, "cells along a patch side", found.cells.to_string(), expected.cells.to_string()),
        (found_text != expected_text || found.name != expected.name, "the recipe", text(found), text(expected)),
        (found.assets != expected.assets, "the recipe's files", size(&found.assets), size(&expected.assets)),
        (found.lattice != expected.lattice, "the lattice", lattice(found), lattice(expected)),
        (found.height_range != expected.height_range, "the height range", range(found), range(expected)),
    ];
    let edits = found_text.strip_prefix(&*expected_text).filter(|rest| rest.starts_with("\n[[edit]]"));
    match differs.into_iter().find(|d| d.0) {
        None => Ok(()),
        Some((_, "the recipe", ..)) if edits.is_some() => Err(StoreError::Edited { file: path.to_owned() }),
        Some((_, what, found, expected)) => Err(StoreError::Differs { file: path.to_owned(), what, found, expected }),
    }
}
