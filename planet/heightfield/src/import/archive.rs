//! Compressed files: gzip, and zip archives that hold one elevation file. In: their bytes. Out: those of the file inside, and
//! its name.

use super::{Fault, ImportError, Source, MOST_SAMPLES};
use flate2::read::MultiGzDecoder;
use std::io::{Cursor, Read};
use std::path::Path;
use zip::ZipArchive;

/// Most bytes of a file inside, so that small archives cannot ask for all memory.
const MOST_BYTES: u64 = 8 * MOST_SAMPLES as u64;

/// Most bytes that deflate makes of one.
const MOST_A_BYTE: u64 = 1032;

/// Names of files inside that are of interest.
const EXTENSIONS: [&str; 8] = ["hgt", "tif", "tiff", "asc", "raw", "r16", "r32", "png"];

/// A file inside.
pub(super) struct Inside {
    pub(super) name: String,
    pub(super) bytes: Vec<u8>,
}

/// The file inside a compressed one; nothing if it is not compressed.
pub(super) fn open(source: &Source) -> Result<Option<Inside>, ImportError> {
    match source.bytes {
        [0x1f, 0x8b, ..] => gzip(source).map(Some),
        [b'P', b'K', 3, 4, ..] => zip(source).map(Some),
        _ => Ok(None),
    }
}

fn gzip(source: &Source) -> Result<Inside, ImportError> {
    let bytes = read_all(source, MultiGzDecoder::new(source.bytes))?;
    let name = source.name.strip_suffix(".gz").or(source.name.strip_suffix(".GZ")).unwrap_or(source.name);
    Ok(Inside { name: name.to_owned(), bytes })
}

fn zip(source: &Source) -> Result<Inside, ImportError> {
    let damaged = |e: zip::result::ZipError| source.refuse(Fault::Damaged, e.to_string(), "an undamaged zip archive");
    let mut archive = ZipArchive::new(Cursor::new(source.bytes)).map_err(damaged)?;
    let wanted = |name: &String| {
        let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        // Some systems put their own notes beside every file.
        EXTENSIONS.contains(&extension.as_str()) && !name.starts_with("__MACOSX")
    };
    let names: Vec<String> = archive.file_names().filter_map(|name| Some(name.ok()?.into_owned())).filter(wanted).collect();
    let [name] = names.as_slice() else {
        let found = format!("an archive of {} elevation files", names.len());
        return Err(source.refuse(Fault::Kind, found, "one").with_advice("unpack it, and name the files that are meant"));
    };
    let file = archive.by_name(name).map_err(damaged)?;
    let bytes = read_all(source, file)?;
    // The name of a tile says where it lies; that of the archive, where the user has it.
    Ok(Inside { name: format!("{}/{name}", source.name), bytes })
}

fn read_all(source: &Source, file: impl Read) -> Result<Vec<u8>, ImportError> {
    let most = MOST_BYTES.min(source.length.saturating_mul(MOST_A_BYTE));
    let mut bytes = Vec::new();
    let read = file.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|e| source.refuse(Fault::Damaged, e.to_string(), "undamaged compressed bytes"))?;
    if bytes.len() as u64 > most {
        return Err(source.refuse(Fault::Size, format!("more than {most} bytes inside"), format!("at most {most}")));
    }
    Ok(bytes)
}
