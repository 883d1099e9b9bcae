//! A patch's facts as they are stored: bytes in the geometry record and under the row's checksum, columns in the row.

use super::error::RecordError;
use super::record::RecordReader;
use crate::globe::lattice::{LatticeBox, EXTENT};
use crate::mesh::progressive::{PatchFacts, Quarter};
use glam::IVec3;
use rusqlite::types::Value;
use rusqlite::Row;

/// Length of [`bytes`]: box 24, heights 8, child wake 8, and of each quarter heights 8, deviation 8.
pub(super) const BYTES: usize = 40 + QUARTERS;

/// Length of what is stored of the quarters.
const QUARTERS: usize = 4 * 16;

/// Number of [`columns`].
pub(super) const COLUMNS: usize = 10;

/// Box and heights, in the order in which they are stored.
fn whole_numbers(facts: &PatchFacts) -> [i32; 8] {
    let [low, high] = [facts.bounds.low, facts.bounds.high];
    [low.x, low.y, low.z, high.x, high.y, high.z, facts.heights[0], facts.heights[1]]
}

/// The facts of [`whole_numbers`] and what follows them.
fn of_numbers([x0, y0, z0, x1, y1, z1, low, high]: [i32; 8], child_wake: f64, quarters: [Quarter; 4]) -> PatchFacts {
    let bounds = LatticeBox { low: IVec3::new(x0, y0, z0), high: IVec3::new(x1, y1, z1) };
    PatchFacts { bounds, heights: [low, high], child_wake, quarters }
}

/// Quarters as little-endian bytes.
fn bytes_of_quarters(quarters: &[Quarter; 4]) -> Vec<u8> {
    let bytes = |q: &Quarter| {
        let [low, high] = q.heights.map(i32::to_le_bytes);
        [low.as_slice(), &high, &q.deviation.to_le_bytes()].concat()
    };
    quarters.iter().flat_map(bytes).collect()
}

/// Facts as little-endian bytes.
pub(crate) fn bytes(facts: &PatchFacts) -> Vec<u8> {
    let mut bytes: Vec<u8> = whole_numbers(facts).iter().flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend(facts.child_wake.to_le_bytes());
    bytes.extend(bytes_of_quarters(&facts.quarters));
    bytes
}

/// Reads what [`bytes`] wrote.
pub(crate) fn read(record: &mut RecordReader<'_>) -> Result<PatchFacts, RecordError> {
    let mut numbers = [0; 8];
    for (k, number) in numbers.iter_mut().enumerate() {
        *number = record.i32(if k < 6 { "bounds" } else { "heights" })?;
    }
    let child_wake = record.f64("child wake")?;
    let mut quarters = [Quarter { heights: [0; 2], deviation: 0.0 }; 4];
    for quarter in &mut quarters {
        quarter.heights = [record.i32("heights of a quarter")?, record.i32("heights of a quarter")?];
        quarter.deviation = record.f64("deviation of a quarter")?;
    }
    Ok(of_numbers(numbers, child_wake, quarters))
}

/// Facts as columns of the patch table, from `low_x` to `quarters`.
pub(super) fn columns(facts: &PatchFacts) -> [Value; COLUMNS] {
    let [x0, y0, z0, x1, y1, z1, low, high] = whole_numbers(facts).map(Value::from);
    [x0, y0, z0, x1, y1, z1, low, high, facts.child_wake.into(), bytes_of_quarters(&facts.quarters).into()]
}

/// Reads [`columns`], the first of which is at `first`.
pub(super) fn of_row(row: &Row, first: usize) -> rusqlite::Result<PatchFacts> {
    let mut numbers = [0; 8];
    for (k, number) in numbers.iter_mut().enumerate() {
        *number = row.get(first + k)?;
    }
    let stored: [u8; QUARTERS] = row.get(first + 9)?;
    let quarter = |k: usize| {
        let [low, high, deviation, deviation_high] =
            [0, 4, 8, 12].map(|at| std::array::from_fn(|byte| stored[16 * k + at + byte]));
        let deviation = u64::from(u32::from_le_bytes(deviation)) | u64::from(u32::from_le_bytes(deviation_high)) << 32;
        Quarter { heights: [i32::from_le_bytes(low), i32::from_le_bytes(high)], deviation: f64::from_bits(deviation) }
    };
    Ok(of_numbers(numbers, row.get(first + 8)?, std::array::from_fn(quarter)))
}

/// Checks facts alone, without the vertices.
pub(crate) fn check(facts: &PatchFacts) -> Result<(), &'static str> {
    let PatchFacts { bounds, heights, child_wake, quarters } = *facts;
    let inside = |p: IVec3| p.cmpge(IVec3::splat(-EXTENT)).all() && p.cmple(IVec3::splat(EXTENT)).all();
    if !inside(bounds.low) || !inside(bounds.high) || !bounds.low.cmple(bounds.high).all() {
        return Err("the bounds are not a box inside the lattice");
    }
    if heights[0] > heights[1] || quarters.iter().any(|quarter| quarter.heights[0] > quarter.heights[1]) {
        return Err("the lowest vertex is above the highest");
    }
    // The builder's child wakes are finite, those of vertices that collapse. An infinite one is no danger: such a patch always splits.
    let sound = |quarter: &Quarter| quarter.deviation >= 0.0 && quarter.deviation.is_finite();
    if !(quarters.iter().all(sound) && child_wake >= 0.0) {
        return Err("deviation or child wake is negative or not a number");
    }
    Ok(())
}
