//! A patch's facts as they are stored: bytes in the geometry record and under the row's checksum, columns in the row.

use super::error::RecordError;
use super::record::RecordReader;
use crate::globe::lattice::{LatticeBox, EXTENT};
use crate::mesh::progressive::PatchFacts;
use glam::IVec3;
use rusqlite::types::Value;
use rusqlite::Row;

/// Length of [`bytes`]: box 24, heights 8, deviation 8, child wake 8.
pub(super) const BYTES: usize = 48;

/// Number of [`columns`].
pub(super) const COLUMNS: usize = 10;

/// Box and heights, in the order in which they are stored.
fn whole_numbers(facts: &PatchFacts) -> [i32; 8] {
    let [low, high] = [facts.bounds.low, facts.bounds.high];
    [low.x, low.y, low.z, high.x, high.y, high.z, facts.heights[0], facts.heights[1]]
}

/// The facts of [`whole_numbers`] and what follows them.
fn of_numbers([x0, y0, z0, x1, y1, z1, low, high]: [i32; 8], deviation: f64, child_wake: f64) -> PatchFacts {
    let bounds = LatticeBox { low: IVec3::new(x0, y0, z0), high: IVec3::new(x1, y1, z1) };
    PatchFacts { bounds, heights: [low, high], deviation, child_wake }
}

/// Facts as little-endian bytes.
pub(super) fn bytes(facts: &PatchFacts) -> Vec<u8> {
    let mut bytes: Vec<u8> = whole_numbers(facts).iter().flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend([facts.deviation, facts.child_wake].iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

/// Reads what [`bytes`] wrote.
pub(super) fn read(record: &mut RecordReader<'_>) -> Result<PatchFacts, RecordError> {
    let mut numbers = [0; 8];
    for (k, number) in numbers.iter_mut().enumerate() {
        *number = record.i32(if k < 6 { "bounds" } else { "heights" })?;
    }
    Ok(of_numbers(numbers, record.f64("deviation")?, record.f64("child wake")?))
}

/// Facts as columns of the patch table, from `low_x` to `child_wake`.
pub(super) fn columns(facts: &PatchFacts) -> [Value; COLUMNS] {
    let [x0, y0, z0, x1, y1, z1, low, high] = whole_numbers(facts).map(Value::from);
    [x0, y0, z0, x1, y1, z1, low, high, facts.deviation.into(), facts.child_wake.into()]
}

/// Reads [`columns`], the first of which is at `first`.
pub(super) fn of_row(row: &Row, first: usize) -> rusqlite::Result<PatchFacts> {
    let mut numbers = [0; 8];
    for (k, number) in numbers.iter_mut().enumerate() {
        *number = row.get(first + k)?;
    }
    Ok(of_numbers(numbers, row.get(first + 8)?, row.get(first + 9)?))
}

/// Checks facts alone, without the vertices.
pub(super) fn check(facts: &PatchFacts) -> Result<(), &'static str> {
    let PatchFacts { bounds, heights, deviation, child_wake } = *facts;
    let inside = |p: IVec3| p.cmpge(IVec3::splat(-EXTENT)).all() && p.cmple(IVec3::splat(EXTENT)).all();
    if !inside(bounds.low) || !inside(bounds.high) || !bounds.low.cmple(bounds.high).all() {
        return Err("the bounds are not a box inside the lattice");
    }
    if heights[0] > heights[1] {
        return Err("the lowest vertex is above the highest");
    }
    // The builder's child wakes are finite, those of vertices that collapse. An infinite one is no danger: such a patch always splits.
    if !(deviation >= 0.0 && deviation.is_finite() && child_wake >= 0.0) {
        return Err("deviation or child wake is negative or not a number");
    }
    Ok(())
}
