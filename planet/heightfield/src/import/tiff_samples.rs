//! The samples of a TIFF, chunk by chunk: which chunks a window needs, what their numbers are, which of them hold no data.

use super::gaps::Gaps;
use super::metadata::Band;
use super::tiff::{refused, Tiff};
use super::{Fault, ImportError, Source, Values, Window};
use tiff::decoder::DecodingResult;

/// How samples are stored.
pub(super) struct Layout {
    pub(super) size: [usize; 2],
    /// The part to read.
    pub(super) window: Window,
    /// Numbers a sample: more than one for colours.
    pub(super) channels: usize,
    /// Columns and rows of a strip or tile.
    pub(super) chunk: [usize; 2],
    /// Bytes of each chunk in the file; 0 for those that are left out.
    pub(super) bytes: Vec<u64>,
}

/// What was read.
pub(super) struct Samples {
    pub(super) values: Values,
    pub(super) heights: Vec<f32>,
    pub(super) notes: Vec<String>,
}

/// All samples of a window.
pub(super) fn read(
    source: &Source,
    file: &mut Tiff,
    layout: &Layout,
    no_data: Option<f64>,
    band: &Band,
) -> Result<Samples, ImportError> {
    let Window { column, row, columns, rows } = layout.window;
    let across = layout.size[0].div_ceil(layout.chunk[0]);
    let chunks = |first: usize, length: usize, side: usize| first / side..=(first + length - 1) / side;
    let mut reader = Reader {
        source,
        gaps: Gaps::new(source, no_data),
        band,
        channels: layout.channels,
        window: layout.window,
        values: Values::Metres,
        heights: vec![f32::NAN; columns * rows],
    };
    let mut missing = 0;
    for down in chunks(row, rows, layout.chunk[1]) {
        for along in chunks(column, columns, layout.chunk[0]) {
            let number = down * across + along;
            if layout.bytes.get(number) == Some(&0) {
                missing += 1;
                continue;
            }
            let decoded = file.read_chunk(number as u32).map_err(|e| refused(source, &e))?;
            let (wide, _) = file.chunk_data_dimensions(number as u32);
            reader.take(decoded, [along * layout.chunk[0], down * layout.chunk[1]], wide as usize, layout.size)?;
        }
    }
    let mut notes = Vec::new();
    if missing > 0 {
        notes.push(format!("{missing} tiles or strips are left out in the file: taken as gaps"));
    }
    if let Some(unit) = band.unit_m.filter(|&unit| unit != 1.0) {
        notes.push(format!("heights of units of {unit:.7} m are turned into metres"));
    }
    Ok(Samples { values: reader.values, heights: reader.heights, notes })
}

struct Reader<'a> {
    source: &'a Source<'a>,
    gaps: Gaps,
    band: &'a Band,
    channels: usize,
    window: Window,
    values: Values,
    heights: Vec<f32>,
}

impl Reader<'_> {
    /// Takes what a chunk at a column and row has of the window.
    fn take(&mut self, decoded: DecodingResult, at: [usize; 2], wide: usize, size: [usize; 2]) -> Result<(), ImportError> {
        if let Some(encoding) = self.source.options.encoding {
            let DecodingResult::U8(bytes) = decoded else { return Err(self.other_type()) };
            let channels = self.channels;
            let pixels: Vec<f32> = bytes
                .chunks_exact(channels)
                .map(
                    |pixel| {
                        if channels == 4 && pixel[3] == 0 {
                            f32::NAN
                        } else {
                            encoding.metres([pixel[0], pixel[1], pixel[2]])
                        }
                    },
                )
                .collect();
            return self.place(&pixels, at, wide, size, f64::from, true);
        }
        match decoded {
            DecodingResult::U8(numbers) => self.levels(&numbers, at, wide, size, 255.0),
            DecodingResult::U16(numbers) => self.levels(&numbers, at, wide, size, 65_535.0),
            DecodingResult::U32(numbers) => self.place(&numbers, at, wide, size, f64::from, false),
            DecodingResult::U64(numbers) => self.place(&numbers, at, wide, size, |n| n as f64, false),
            DecodingResult::I8(numbers) => self.place(&numbers, at, wide, size, f64::from, false),
            DecodingResult::I16(numbers) => self.place(&numbers, at, wide, size, f64::from, false),
            DecodingResult::I32(numbers) => self.place(&numbers, at, wide, size, f64::from, false),
            DecodingResult::I64(numbers) => self.place(&numbers, at, wide, size, |n| n as f64, false),
            DecodingResult::F16(numbers) => self.place(&numbers, at, wide, size, |n| f64::from(n.to_f32()), true),
            DecodingResult::F32(numbers) => self.place(&numbers, at, wide, size, f64::from, true),
            DecodingResult::F64(numbers) => self.place(&numbers, at, wide, size, |n| n, true),
        }
    }

    fn other_type(&self) -> ImportError {
        self.source.refuse(Fault::Kind, "samples of another type", "numbers of 8 to 64 bits")
    }

    /// Unsigned integers: levels, unless the file says what they stand for.
    fn levels<N: Copy + Into<f64>>(
        &mut self,
        numbers: &[N],
        at: [usize; 2],
        wide: usize,
        size: [usize; 2],
        full: f64,
    ) -> Result<(), ImportError> {
        if self.band.is_plain() && self.band.unit_m.is_none() {
            self.values = Values::Levels { full };
        }
        self.place(numbers, at, wide, size, N::into, false)
    }

    fn place<N: Copy>(
        &mut self,
        numbers: &[N],
        [column, row]: [usize; 2],
        wide: usize,
        size: [usize; 2],
        number: impl Fn(N) -> f64,
        floats: bool,
    ) -> Result<(), ImportError> {
        let Window { column: west, row: north, columns, rows } = self.window;
        let east = (west + columns).min(column + wide).min(size[0]);
        for (line, numbers) in numbers.chunks_exact(wide.max(1)).enumerate() {
            let row = row + line;
            if !(north..north + rows).contains(&row) {
                continue;
            }
            for c in column.max(west)..east {
                let height = self.height(number(numbers[c - column]), floats);
                self.heights[(row - north) * columns + c - west] = height.ok_or_else(|| {
                    let found = format!("{} at column {c}, row {row}", number(numbers[c - column]));
                    self.source.refuse(Fault::Sample, found, "finite heights, or a declared no-data value")
                })?;
            }
        }
        Ok(())
    }

    /// A height in metres, NaN for no data, nothing for what is neither.
    fn height(&self, number: f64, floats: bool) -> Option<f32> {
        if self.gaps.holds(number, floats) {
            return Some(f32::NAN);
        }
        let metres = self.band.metres(number);
        // Doubles can be larger than any float; what is that large is looked at later.
        metres.is_finite().then(|| metres.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
    }
}
