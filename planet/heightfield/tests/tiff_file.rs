//! TIFFs by hand: one strip, little-endian, uncompressed, of any sample type, with any tags. For kinds of files that no encoder at
//! hand writes.

use std::collections::BTreeMap;

/// The terrain of all test files: 96 × 64 samples from 400.0 m to 800.0 m, highest in the north-east.
pub(crate) const SIZE: [usize; 2] = [96, 64];

/// Height in metres; multiples of a quarter, which half floats of that size hold, too.
pub(crate) fn height(column: usize, row: usize) -> f64 {
    let (east, north) = (column as f64 / 95.0, (63 - row) as f64 / 63.0);
    (4.0 * (400.0 + 250.0 * east * north + 100.0 * east + 50.0 * north * north)).round() / 4.0
}

/// All heights, north row first.
pub(crate) fn heights() -> Vec<f64> {
    (0..SIZE[0] * SIZE[1]).map(|i| height(i % SIZE[0], i / SIZE[0])).collect()
}

/// The value of a tag.
pub(crate) enum Value<'a> {
    Shorts(&'a [u16]),
    Longs(&'a [u32]),
    Doubles(&'a [f64]),
    Text(&'a str),
}

pub(crate) struct TiffFile {
    entries: BTreeMap<u16, (u16, u32, Vec<u8>)>,
    data: Vec<u8>,
}

/// How samples are stored: bits, and 1 for unsigned, 2 for signed, 3 for floats.
pub(crate) type Kind = [u16; 2];

impl TiffFile {
    /// An image of bytes.
    pub(crate) fn new([columns, rows]: [usize; 2], [bits, format]: Kind, data: Vec<u8>) -> TiffFile {
        let file = TiffFile { entries: BTreeMap::new(), data };
        file.tag(256, Value::Longs(&[columns as u32]))
            .tag(257, Value::Longs(&[rows as u32]))
            .tag(258, Value::Shorts(&[bits]))
            .tag(259, Value::Shorts(&[1]))
            .tag(262, Value::Shorts(&[1]))
            .tag(277, Value::Shorts(&[1]))
            .tag(278, Value::Longs(&[rows as u32]))
            .tag(339, Value::Shorts(&[format]))
    }

    /// The terrain, each height as bytes.
    pub(crate) fn terrain(kind: Kind, bytes: impl Fn(f64) -> Vec<u8>) -> TiffFile {
        TiffFile::new(SIZE, kind, heights().into_iter().flat_map(bytes).collect())
    }

    /// The terrain in single floats.
    pub(crate) fn floats() -> TiffFile {
        TiffFile::terrain([32, 3], |h| (h as f32).to_le_bytes().to_vec())
    }

    pub(crate) fn tag(mut self, tag: u16, value: Value) -> TiffFile {
        let entry = match value {
            Value::Shorts(v) => (3, v.len() as u32, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Value::Longs(v) => (4, v.len() as u32, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Value::Doubles(v) => (12, v.len() as u32, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Value::Text(text) => (2, text.len() as u32 + 1, [text.as_bytes(), &[0]].concat()),
        };
        self.entries.insert(tag, entry);
        self
    }

    /// A tie point at the corner of the first sample, and steps.
    pub(crate) fn at(self, [x, y]: [f64; 2], step: [f64; 2]) -> TiffFile {
        self.tag(33_922, Value::Doubles(&[0.0, 0.0, 0.0, x, y, 0.0])).tag(33_550, Value::Doubles(&[step[0], step[1], 0.0]))
    }

    /// Keys of a GeoTIFF that are numbers in the directory, and doubles beside it.
    pub(crate) fn keys(self, codes: &[(u16, u16)], numbers: &[(u16, f64)]) -> TiffFile {
        let mut all: Vec<[u16; 4]> = codes.iter().map(|&(key, code)| [key, 0, 1, code]).collect();
        all.extend(numbers.iter().enumerate().map(|(i, &(key, _))| [key, 34_736, 1, i as u16]));
        all.sort_unstable();
        let head = [1, 1, 0, all.len() as u16];
        let directory: Vec<u16> = head.into_iter().chain(all.into_iter().flatten()).collect();
        let doubles: Vec<f64> = numbers.iter().map(|n| n.1).collect();
        let file = self.tag(34_735, Value::Shorts(&directory));
        if doubles.is_empty() {
            file
        } else {
            file.tag(34_736, Value::Doubles(&doubles))
        }
    }

    /// The file's bytes.
    pub(crate) fn bytes(mut self) -> Vec<u8> {
        let strip = self.data.len() as u32;
        if !self.entries.contains_key(&279) {
            self = self.tag(279, Value::Longs(&[strip]));
        }
        self = self.tag(273, Value::Longs(&[8]));
        let mut file = [b"II*\0".as_slice(), &[0; 4], &self.data].concat();
        file.resize(file.len().next_multiple_of(2), 0);
        let mut entries = Vec::new();
        for (tag, (kind, count, value)) in &self.entries {
            entries.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            entries.extend(count.to_le_bytes());
            if value.len() <= 4 {
                let mut short = value.clone();
                short.resize(4, 0);
                entries.extend(short);
            } else {
                entries.extend((file.len() as u32).to_le_bytes());
                file.extend(value);
                file.resize(file.len().next_multiple_of(2), 0);
            }
        }
        let start = file.len() as u32;
        file[4..8].copy_from_slice(&start.to_le_bytes());
        file.extend((self.entries.len() as u16).to_le_bytes());
        file.extend(entries);
        file.extend([0; 4]);
        file
    }
}
