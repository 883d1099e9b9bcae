//! Why a heightfield file is refused: what is wrong, in which file, what was found, what was expected, what to do next.

use super::{MOST_SAMPLES, MOST_SAMPLES_PER_BYTE};

/// What is wrong with a heightfield file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The system cannot read it.
    Unreadable,
    /// Neither its bytes nor its name are those of a known format.
    Format,
    /// It has too few or too many bytes.
    Length,
    /// Fewer than 2 × 2 samples, or more than [`MOST_SAMPLES`].
    Size,
    /// A sound image, but one that holds no heights: colours, alpha, or numbers of another type.
    Kind,
    /// Its bytes break the rules of its format.
    Damaged,
    /// A sample that is no height.
    Sample,
    /// No sample holds data.
    Empty,
}

impl Fault {
    /// What the owner of such a file can do.
    pub fn advice(self) -> &'static str {
        match self {
            Fault::Unreadable => "check the path and its permissions",
            Fault::Format => "convert it with gdal_translate, or rename it",
            Fault::Length => "export or download it again; RAW must be square, 16-bit and without a header",
            Fault::Size => "crop or resample it, for instance with gdal_translate -srcwin or -outsize",
            Fault::Kind => "convert it, for instance with gdal_translate -ot Int16 -b 1",
            Fault::Damaged => "export or download it again",
            Fault::Sample => "declare a no-data value, for instance with gdal_translate -a_nodata nan",
            Fault::Empty => "choose another file, or another part of it",
        }
    }
}

/// Why a heightfield file was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: found {found}, expected {expected}; {}", .fault.advice())]
pub struct ImportError {
    /// The file's name.
    pub file: Box<str>,
    /// What is wrong.
    pub fault: Fault,
    /// What was found.
    pub found: Box<str>,
    /// What was expected.
    pub expected: Box<str>,
}

/// A file that is being read.
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) bytes: &'a [u8],
}

impl Source<'_> {
    /// An error about this file.
    pub(super) fn refuse(&self, fault: Fault, found: impl Into<Box<str>>, expected: impl Into<Box<str>>) -> ImportError {
        ImportError { file: self.name.into(), fault, found: found.into(), expected: expected.into() }
    }

    /// Checks the size that a file states, before memory is taken for it. Out: the number of samples.
    pub(super) fn check_size(&self, [columns, rows]: [usize; 2]) -> Result<usize, ImportError> {
        let found = format!("{columns} x {rows} samples");
        if columns < 2 || rows < 2 {
            return Err(self.refuse(Fault::Size, found, "at least 2 x 2"));
        }
        let samples = columns.checked_mul(rows).filter(|&s| s <= MOST_SAMPLES);
        let samples = samples.ok_or_else(|| self.refuse(Fault::Size, found.as_str(), format!("at most {MOST_SAMPLES}")))?;
        if samples / MOST_SAMPLES_PER_BYTE > self.bytes.len() {
            let found = format!("{found} stated in a file of {} bytes", self.bytes.len());
            return Err(self.refuse(Fault::Damaged, found, "a file that can hold them"));
        }
        Ok(samples)
    }
}
