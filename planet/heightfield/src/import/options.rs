//! What the owner of a file says about it where the file does not, or where it is wrong.

use super::{Fault, ImportError, Source};

/// How to read a file beyond what it says itself. The default adds nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// The coordinate system, as `EPSG:2264`, a proj string or WKT; it takes the place of the file's.
    pub crs: Option<String>,
    /// What stands for no data beside what the file declares; in the file's own numbers.
    pub no_data: Option<NoData>,
    /// How colours stand for heights.
    pub encoding: Option<Encoding>,
    /// Columns and rows of a RAW file.
    pub raw_size: Option<[usize; 2]>,
    /// What the samples of a RAW file are; by its name, else 16-bit little-endian.
    pub raw_type: Option<RawType>,
    /// The part to read, in samples of the file.
    pub window: Option<Window>,
    /// Which of a TIFF's overviews to read: 1 is the finest.
    pub overview: Option<usize>,
    /// Most samples to take memory for, if fewer than [`super::MOST_SAMPLES`].
    pub most_samples: Option<usize>,
    /// Bytes that the caller needs a sample, for messages about [`Options::most_samples`].
    pub bytes_a_sample: Option<usize>,
}

/// What stands for no data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoData {
    /// Besides what the file declares, this number.
    Value(f64),
    /// Only what the file declares: numbers that look like missing data are heights.
    Declared,
}

/// How the colours of an image stand for heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// `256 red + green + blue / 256 - 32768` metres. (Mapzen, Terrarium.)
    Terrarium,
    /// `(65536 red + 256 green + blue) / 10 - 10000` metres. (Mapbox, Terrain-RGB.)
    Mapbox,
}

/// What the samples of a RAW file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawType {
    /// The kind of number.
    pub number: RawNumber,
    /// Whether the highest byte comes first.
    pub big_endian: bool,
}

/// A kind of number in RAW files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "their names say it: letter and bits")]
pub enum RawNumber {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

/// A rectangle of samples of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its first column.
    pub column: usize,
    /// Its first row.
    pub row: usize,
    /// Samples from west to east.
    pub columns: usize,
    /// Samples from north to south.
    pub rows: usize,
}

impl Encoding {
    /// An encoding by its name.
    pub fn named(name: &str) -> Option<Encoding> {
        match name {
            "terrarium" => Some(Encoding::Terrarium),
            "mapbox" => Some(Encoding::Mapbox),
            _ => None,
        }
    }

    /// Metres of a colour.
    pub(super) fn metres(self, [red, green, blue]: [u8; 3]) -> f32 {
        let [red, green, blue] = [red, green, blue].map(f64::from);
        let metres = match self {
            Encoding::Terrarium => 256.0 * red + green + blue / 256.0 - 32_768.0,
            Encoding::Mapbox => (65_536.0 * red + 256.0 * green + blue) / 10.0 - 10_000.0,
        };
        metres as f32
    }
}

impl RawType {
    /// Names of all types.
    pub const NAMES: &'static str =
        "u8, i8, u16le, u16be, i16le, i16be, u32le, u32be, i32le, i32be, f32le, f32be, f64le or f64be";

    /// Terragen's and Unity's: 16-bit little-endian levels.
    pub(super) const LEVELS: RawType = RawType { number: RawNumber::U16, big_endian: false };

    /// Floats as `.r32` files hold them.
    pub(super) const FLOATS: RawType = RawType { number: RawNumber::F32, big_endian: false };

    /// A type by its name.
    pub fn named(name: &str) -> Option<RawType> {
        let (number, order) = name.split_at(name.find(['l', 'b']).unwrap_or(name.len()));
        let number = match number {
            "u8" => RawNumber::U8,
            "i8" => RawNumber::I8,
            "u16" => RawNumber::U16,
            "i16" => RawNumber::I16,
            "u32" => RawNumber::U32,
            "i32" => RawNumber::I32,
            "f32" => RawNumber::F32,
            "f64" => RawNumber::F64,
            _ => return None,
        };
        match order {
            "le" => Some(RawType { number, big_endian: false }),
            "be" => Some(RawType { number, big_endian: true }),
            "" if number.bytes() == 1 => Some(RawType { number, big_endian: false }),
            _ => None,
        }
    }
}

impl RawNumber {
    /// Bytes of one number.
    pub(super) fn bytes(self) -> usize {
        match self {
            RawNumber::U8 | RawNumber::I8 => 1,
            RawNumber::U16 | RawNumber::I16 => 2,
            RawNumber::U32 | RawNumber::I32 | RawNumber::F32 => 4,
            RawNumber::F64 => 8,
        }
    }
}

impl Window {
    /// All of a file.
    pub(super) fn whole([columns, rows]: [usize; 2]) -> Window {
        Window { column: 0, row: 0, columns, rows }
    }

    /// Its size.
    pub(super) fn size(self) -> [usize; 2] {
        [self.columns, self.rows]
    }
}

impl Options {
    /// The part of a file of some size that is wanted.
    pub(super) fn part(&self, source: &Source, [columns, rows]: [usize; 2]) -> Result<Window, ImportError> {
        let Some(wanted) = self.window else { return Ok(Window::whole([columns, rows])) };
        let fits = |first: usize, length: usize, most: usize| first.checked_add(length).is_some_and(|end| end <= most);
        if fits(wanted.column, wanted.columns, columns) && fits(wanted.row, wanted.rows, rows) {
            return Ok(wanted);
        }
        let Window { column, row, columns: wide, rows: high } = wanted;
        let found = format!("a window of {wide} x {high} samples from column {column}, row {row}");
        let error = source.refuse(Fault::Size, found, format!("a window inside {columns} x {rows} samples"));
        Err(error.with_advice("choose a smaller window"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_types_have_names() {
        for name in RawType::NAMES.replace(" or ", ", ").split(", ") {
            assert!(RawType::named(name).is_some(), "{name}");
        }
        for name in ["u16", "u8be2", "f16le", "i64le", "", "le", "ü16le"] {
            assert_eq!(RawType::named(name), None, "{name}");
        }
    }

    #[test]
    fn colours_stand_for_heights() {
        assert_eq!([Encoding::Terrarium.metres([128, 0, 0]), Encoding::Terrarium.metres([127, 255, 128])], [0.0, -0.5]);
        assert_eq!([Encoding::Mapbox.metres([1, 134, 160]), Encoding::Mapbox.metres([1, 134, 165])], [0.0, 0.5]);
    }
}
