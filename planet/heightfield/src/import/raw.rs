//! Samples without a header (`.raw`, `.r16`, `.r32`), north row first: by default squares of 16-bit little-endian levels, as
//! Terragen and Unity export; of any size and type where they are stated.

use super::gaps::Gaps;
use super::options::{RawNumber, RawType};
use super::{Fault, Format, ImportError, Imported, Source, Values};

/// Reads a RAW file whose samples are of some type unless its owner says otherwise.
pub(super) fn read(source: &Source, usual: RawType) -> Result<Imported, ImportError> {
    let kind = source.options.raw_type.unwrap_or(usual);
    let size = size(source, kind)?;
    let full = source.options.part(source, size)?;
    source.check_part(full.size())?;
    let gaps = Gaps::new(source, None);
    let width = kind.number.bytes();
    let floats = matches!(kind.number, RawNumber::F32 | RawNumber::F64);
    let mut heights = Vec::with_capacity(full.columns * full.rows);
    for row in full.row..full.row + full.rows {
        let line = &source.bytes[(row * size[0] + full.column) * width..][..full.columns * width];
        for (k, bytes) in line.chunks_exact(width).enumerate() {
            let number = number(kind, bytes);
            if number.is_infinite() {
                let found = format!("{number} at column {}, row {row}", full.column + k);
                return Err(source.refuse(Fault::Sample, found, "finite heights"));
            }
            let height = number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
            heights.push(if gaps.holds(number, floats) { f32::NAN } else { height });
        }
    }
    let values = values(kind.number, &heights);
    Imported::new(source, Format::Raw, values, full.size(), heights)
}

/// Columns and rows: as stated, or a square.
fn size(source: &Source, kind: RawType) -> Result<[usize; 2], ImportError> {
    let (length, width) = (source.bytes.len(), kind.number.bytes());
    if let Some([columns, rows]) = source.options.raw_size {
        let bytes = columns.checked_mul(rows).and_then(|samples| samples.checked_mul(width));
        if bytes != Some(length) {
            let wanted =
                format!("{columns} x {rows} samples of {width} bytes, {} in all", columns as f64 * rows as f64 * width as f64);
            return Err(source.refuse(Fault::Length, format!("{length} bytes"), wanted));
        }
        return Ok([columns, rows]);
    }
    let side = (length / width).isqrt();
    if width * side * side != length {
        let next = width * (side + 1) * (side + 1);
        let name = if width == 2 { "two".to_owned() } else { width.to_string() };
        let expected = format!("{name} bytes a sample of a square: {} ({side} x {side}) or {next} bytes", width * side * side);
        return Err(source.refuse(Fault::Length, format!("{length} bytes"), expected));
    }
    Ok([side, side])
}

fn number(RawType { number, big_endian }: RawType, bytes: &[u8]) -> f64 {
    let mut low_first = [0; 8];
    let ordered = &mut low_first[..bytes.len()];
    ordered.copy_from_slice(bytes);
    if big_endian {
        ordered.reverse();
    }
    let [a, b, c, d, ..] = low_first;
    match number {
        RawNumber::U8 => f64::from(a),
        RawNumber::I8 => f64::from(a as i8),
        RawNumber::U16 => f64::from(u16::from_le_bytes([a, b])),
        RawNumber::I16 => f64::from(i16::from_le_bytes([a, b])),
        RawNumber::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        RawNumber::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        RawNumber::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        RawNumber::F64 => f64::from_le_bytes(low_first),
    }
}

/// Unsigned integers are levels, and so are floats from 0 to 1; all else is metres.
fn values(number: RawNumber, heights: &[f32]) -> Values {
    match number {
        RawNumber::U8 => Values::Levels { full: 255.0 },
        RawNumber::U16 => Values::Levels { full: 65_535.0 },
        RawNumber::U32 => Values::Levels { full: f64::from(u32::MAX) },
        RawNumber::F32 | RawNumber::F64 if heights.iter().all(|h| h.is_nan() || (0.0..=1.0).contains(h)) => {
            Values::Levels { full: 1.0 }
        }
        _ => Values::Metres,
    }
}
