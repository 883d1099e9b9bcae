//! What the user of a window chooses, and every frame obeys.

use super::pacing::Scale;
use crate::frame::Look;

/// How the picture looks, and how well the mesh follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choices {
    pub(super) look: Look,
    /// Seconds since 1970 of the time that the sun was put to, if it was.
    pub(super) date: Option<i64>,
    /// Largest error of the mesh in pixels.
    pub(super) tolerance: f64,
    /// Whether vertices slide into their positions.
    pub(super) geomorphs: bool,
    /// Whether errors count as they are seen.
    pub(super) orientation: bool,
    /// How many pixels are drawn.
    pub(super) scale: Scale,
    /// What `scale` is while it follows a budget.
    pub(super) budget: Scale,
}
