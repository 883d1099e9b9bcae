//! Regions that a file is baked deeper in.

use glam::DVec3;

/// Part of a planet that is baked finer than the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Unit direction of the centre.
    pub direction: DVec3,
    /// Radius along the ground, in metres.
    pub radius_m: f64,
    /// Finest level inside.
    pub to_level: u8,
}
