//! Terragen's RAW export: a square of 16-bit little-endian levels, north row first, without a header.

use super::{Fault, Format, ImportError, Imported, Source, Values};

/// Reads a RAW file; its size follows from its length.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let length = source.bytes.len();
    let side = (length / 2).isqrt();
    if 2 * side * side != length {
        let next = 2 * (side + 1) * (side + 1);
        let expected = format!("two bytes a sample of a square: {} ({side} x {side}) or {next} bytes", 2 * side * side);
        return Err(source.refuse(Fault::Length, format!("{length} bytes"), expected));
    }
    source.check_size([side, side])?;
    let heights = source.bytes.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]]))).collect();
    Imported::new(source, Format::Raw, Values::Levels { full: 65_535.0 }, [side, side], heights)
}
