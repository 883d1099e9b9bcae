//! Tables of a planet file, and what tells it from other files before SQLite is asked.

use super::error::StoreError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// SQLite application id of planet files: "TERR".
pub const APPLICATION_ID: u32 = 0x5445_5252;

/// SQLite user version of planet files: tables, records and the builder's rules together.
pub const FORMAT_VERSION: u32 = 7;

/// `surroundings` and `map` hold what could be computed again.
/// `cached` names the patches that were built while flying and may go again; the others were baked to stay.
///
/// Everything but the pragmas that stamp the file. The patch key packs face, level, column and row, so that a patch is found
/// through one tree; blobs come last, so that an index is read without them. An empty blob is a part that the patch lacks.
pub(super) const TABLES: &str = "
CREATE TABLE planet (
    name TEXT NOT NULL, recipe TEXT NOT NULL, cells INTEGER NOT NULL, kappa REAL NOT NULL, deviation_share REAL NOT NULL,
    lattice_unit REAL NOT NULL, lattice_radius REAL NOT NULL, lowest_m REAL NOT NULL, highest_m REAL NOT NULL,
    checksum INTEGER NOT NULL);
CREATE TABLE asset (place INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, bytes BLOB NOT NULL);
CREATE TABLE region (
    x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL, radius_m REAL NOT NULL, to_level INTEGER NOT NULL,
    UNIQUE (x, y, z, radius_m, to_level));
CREATE TABLE tally (patches INTEGER NOT NULL, combined INTEGER NOT NULL);
CREATE TABLE patch (
    key INTEGER PRIMARY KEY, face INTEGER NOT NULL, level INTEGER NOT NULL, x INTEGER NOT NULL, y INTEGER NOT NULL,
    low_x INTEGER NOT NULL, low_y INTEGER NOT NULL, low_z INTEGER NOT NULL,
    high_x INTEGER NOT NULL, high_y INTEGER NOT NULL, high_z INTEGER NOT NULL,
    lowest INTEGER NOT NULL, highest INTEGER NOT NULL, child_wake REAL NOT NULL, quarters BLOB NOT NULL,
    always_awake INTEGER NOT NULL, checksum INTEGER NOT NULL, geometry BLOB NOT NULL, texture BLOB NOT NULL);
CREATE TABLE surroundings (key INTEGER PRIMARY KEY, heights BLOB NOT NULL);
CREATE TABLE map (name TEXT PRIMARY KEY, texels BLOB NOT NULL);
CREATE TABLE cached (key INTEGER PRIMARY KEY, used INTEGER NOT NULL, bytes INTEGER NOT NULL);
INSERT INTO tally VALUES (0, 0);
";

/// Bytes of an SQLite file's own header.
const SQLITE_HEADER: usize = 100;

/// Files by their first bytes, to name what was found.
const KNOWN: [(&[u8], &str); 5] = [
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"PK\x03\x04", "a zip archive"),
    (b"\x7fELF", "a program"),
    (b"#!", "a script"),
];

/// Whether a file starts like a planet file, of whatever version.
pub fn is_planet_file(path: &Path) -> bool {
    let mut head = [0; SQLITE_HEADER];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head.starts_with(b"SQLite format 3\0") && head[68..72] == APPLICATION_ID.to_be_bytes()
}

/// Refuses whatever does not start like a planet file of this version. These bytes never change after the file is made.
pub(super) fn check_stamp(path: &Path) -> Result<(), StoreError> {
    let system = |source| StoreError::System { file: path.to_owned(), action: "read the planet file", source };
    let mut head = Vec::with_capacity(SQLITE_HEADER);
    File::open(path).and_then(|f| f.take(SQLITE_HEADER as u64).read_to_end(&mut head)).map_err(system)?;
    let foreign = |found: String| Err(StoreError::Foreign { file: path.to_owned(), found });
    if head.is_empty() {
        return foreign("an empty file".into());
    }
    if let Some((_, name)) = KNOWN.into_iter().find(|(magic, _)| head.starts_with(magic)) {
        return foreign(name.into());
    }
    if !head.starts_with(b"SQLite format 3\0") {
        let text = head.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
        return foreign(if text { "a text file".into() } else { "a file of unknown kind".into() });
    }
    let field = |at: usize| head.get(at..at + 4).map(|b| b.iter().fold(0u32, |n, &b| n << 8 | u32::from(b)));
    let (Some(version), Some(application)) = (field(60), field(68)) else {
        return Err(StoreError::Damaged {
            file: path.to_owned(),
            what: format!("{} bytes, too few for any database", head.len()),
        });
    };
    if application != APPLICATION_ID {
        return foreign(format!("another SQLite database (application id {application:#010x}, expected {APPLICATION_ID:#010x})"));
    }
    if version != FORMAT_VERSION {
        let newer = "it was written by a newer Terrane: use that one, or bake into another file";
        let older = "it was written by an older Terrane: delete it and bake it again";
        let advice = if version > FORMAT_VERSION { newer } else { older };
        return Err(StoreError::Version { file: path.to_owned(), found: version, expected: FORMAT_VERSION, advice });
    }
    Ok(())
}
