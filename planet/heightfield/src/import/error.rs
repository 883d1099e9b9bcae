//! Why a heightfield file is refused: what is wrong, in which file, what was found, what was expected, what to do next.

use super::{Options, MOST_SAMPLES, MOST_SAMPLES_PER_BYTE};
use std::path::Path;

/// What is wrong with a heightfield file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The system cannot read it.
    Unreadable,
    /// Neither its bytes nor its name are those of a known format.
    Format,
    /// It has too few or too many bytes.
    Length,
    /// Fewer than 2 × 2 samples, or more than [`MOST_SAMPLES`] or than there is memory for.
    Size,
    /// A sound image, but one that holds no heights: colours, alpha, or a coding of another kind.
    Kind,
    /// Its bytes break the rules of its format.
    Damaged,
    /// A sample that is no height.
    Sample,
    /// No sample holds data.
    Empty,
    /// Where it lies, or how long its steps are, is stated in a way that is not understood.
    Place,
    /// It does not touch the files that it is to be joined with, or does not fit them.
    Apart,
}

impl Fault {
    /// What the owner of such a file can do, unless the error knows better.
    pub fn advice(self) -> &'static str {
        match self {
            Fault::Unreadable => "check the path and its permissions",
            Fault::Format => FORMAT_ADVICE,
            Fault::Length => "export or download it again; a file without a header is a square of 16 bits, or its size and type are stated (--raw-size WxH, --raw-type u16le)",
            Fault::Size => {
                "take a part of it (--window COLUMN,ROW,COLUMNS,ROWS), or resample it, for instance with gdal_translate -outsize"
            }
            Fault::Kind => "convert it with gdal_translate, keeping its type (no -ot)",
            Fault::Damaged => "export or download it again",
            Fault::Sample => "name it as no data (--no-data V)",
            Fault::Empty => "choose another file, or another part of it",
            Fault::Place => {
                "state the coordinate system (--crs EPSG:… or a proj string), or the metres between samples (--spacing M)"
            }
            Fault::Apart => "join files of one coordinate system and one spacing that touch, or give each its own layer",
        }
    }
}

const FORMAT_ADVICE: &str = if cfg!(feature = "gdal") {
    "neither Terrane nor the system's GDAL knows it: convert it to GeoTIFF, or rename it"
} else {
    "convert it to GeoTIFF with gdal_translate, rename it, or build with `--features gdal`, which reads whatever the system's GDAL opens"
};

/// Why a heightfield file was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: found {found}, expected {expected}; {advice}")]
pub struct ImportError {
    /// The file's name.
    pub file: Box<str>,
    /// What is wrong.
    pub fault: Fault,
    /// What was found.
    pub found: Box<str>,
    /// What was expected.
    pub expected: Box<str>,
    /// What its owner can do.
    pub advice: Box<str>,
}

impl ImportError {
    /// The same, with other advice than its fault gives.
    pub(super) fn with_advice(self, advice: impl Into<Box<str>>) -> ImportError {
        ImportError { advice: advice.into(), ..self }
    }
}

/// A file that is being read.
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    /// Its bytes; empty for one that is read in parts.
    pub(super) bytes: &'a [u8],
    /// Where it is read in parts from.
    pub(super) path: Option<&'a Path>,
    /// Its length in bytes.
    pub(super) length: u64,
    pub(super) options: &'a Options,
}

impl<'a> Source<'a> {
    /// A file whose bytes are there.
    pub(super) fn of_bytes(name: &'a str, bytes: &'a [u8], options: &'a Options) -> Source<'a> {
        Source { name, bytes, path: None, length: bytes.len() as u64, options }
    }

    /// An error about this file.
    pub(super) fn refuse(&self, fault: Fault, found: impl Into<Box<str>>, expected: impl Into<Box<str>>) -> ImportError {
        let (file, advice) = (self.name.into(), fault.advice().into());
        ImportError { file, fault, found: found.into(), expected: expected.into(), advice }
    }

    /// Checks the size that a file states, before memory is taken for it. Out: the number of samples.
    pub(super) fn check_size(&self, size: [usize; 2]) -> Result<usize, ImportError> {
        let samples = self.check_part(size)?;
        if (samples / MOST_SAMPLES_PER_BYTE) as u64 > self.length {
            let found = format!("{} x {} samples stated in a file of {} bytes", size[0], size[1], self.length);
            return Err(self.refuse(Fault::Damaged, found, "a file that can hold them"));
        }
        Ok(samples)
    }

    /// Checks the size of what is to be read.
    pub(super) fn check_part(&self, [columns, rows]: [usize; 2]) -> Result<usize, ImportError> {
        let found = format!("{columns} x {rows} samples");
        if columns < 2 || rows < 2 {
            return Err(self.refuse(Fault::Size, found, "at least 2 x 2"));
        }
        let (most, bytes) = (self.options.most_samples.unwrap_or(MOST_SAMPLES), self.options.bytes_a_sample.unwrap_or(4));
        let samples = columns.checked_mul(rows).filter(|&s| s <= MOST_SAMPLES.min(most));
        samples.ok_or_else(|| {
            let needed = columns as f64 * rows as f64 * bytes as f64 / 1e9;
            let found = format!("{found}, which take {needed:.1} GB");
            let expected = match most < MOST_SAMPLES {
                true => format!("at most {most} in the {:.1} GB that are free", most as f64 * bytes as f64 / 1e9),
                false => format!("at most {MOST_SAMPLES}"),
            };
            let advice = "take a part of it (--window COLUMN,ROW,COLUMNS,ROWS), a coarser image of a TIFF that has some \
                          (--overview 1), or resample it, for instance with gdal_translate -outsize";
            self.refuse(Fault::Size, found, expected).with_advice(advice)
        })
    }
}
