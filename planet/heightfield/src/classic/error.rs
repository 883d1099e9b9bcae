//! Why a progressive mesh cannot be made.

use super::split::Refusal;
use crate::plain::PlainError;
use crate::Heightfield;

/// Why a progressive mesh cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClassicError {
    /// Samples have no height.
    #[error(
        "{count} samples have no height, the first at column {column}, row {row}; every sample needs a finite one: \
         fill the gaps before simplifying"
    )]
    Gaps {
        /// How many.
        count: usize,
        /// Column of the first.
        column: usize,
        /// Its row, counted from the north.
        row: usize,
    },
    /// The simplifier of measured errors refuses the field.
    #[error(transparent)]
    Simplify(#[from] PlainError),
    /// Parents of half-edge collapses are not one a sample.
    #[error("{found} parents are given for {expected} samples; expected one for each")]
    Parents {
        /// Parents given.
        found: usize,
        /// Samples of the field.
        expected: usize,
    },
    /// A half-edge collapse is not possible.
    #[error("collapse number {step}, of sample {sample} into {into}, is not possible on the grid: {reason}")]
    Collapse {
        /// Its index in the order, from 0.
        step: usize,
        /// The sample that collapses.
        sample: u32,
        /// Its parent.
        into: u32,
        /// What stands against it.
        reason: Refusal,
    },
}

/// Refuses fields with samples that are not finite.
pub(super) fn refuse_gaps(field: &Heightfield) -> Result<(), ClassicError> {
    let is_gap = |height: &&f32| !height.is_finite();
    match field.heights().iter().position(|height| !height.is_finite()) {
        None => Ok(()),
        Some(first) => Err(ClassicError::Gaps {
            count: field.heights().iter().filter(is_gap).count(),
            column: first % field.columns(),
            row: first / field.columns(),
        }),
    }
}
