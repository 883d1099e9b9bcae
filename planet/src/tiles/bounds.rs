//! Boxes around tiles, along the axes of their patches.

use crate::globe::patch::PatchId;
use crate::ground::texture::tangents;
use glam::DVec3;
use serde_json::{json, Value};

/// Share of a box by which it is wider than what it holds, for the rounding of its numbers.
const SLACK: f64 = 1e-9;

/// A box: along, across and up from the middle of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileBox {
    axes: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

impl TileBox {
    /// The box around no point yet.
    pub(super) fn empty(id: PatchId) -> TileBox {
        let up = id.centre();
        let (along, across) = tangents(id, up);
        TileBox::along([along, across, up])
    }

    /// The same in the axes of the planet.
    pub(super) fn of_planet() -> TileBox {
        TileBox::along(DVec3::AXES)
    }

    fn along(axes: [DVec3; 3]) -> TileBox {
        TileBox { axes, low: DVec3::INFINITY, high: DVec3::NEG_INFINITY }
    }

    /// Grows to hold a point, in metres from the planet's centre.
    pub(super) fn include(&mut self, point: DVec3) {
        let place = DVec3::from_array(self.axes.map(|axis| axis.dot(point)));
        self.low = self.low.min(place);
        self.high = self.high.max(place);
    }

    /// Its corners.
    pub(super) fn corners(&self) -> [DVec3; 8] {
        let (middle, half) = self.middle_and_half();
        std::array::from_fn(|k| {
            let sign = |axis: usize| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
            middle + half[0] * sign(0) + half[1] * sign(1) + half[2] * sign(2)
        })
    }

    fn middle_and_half(&self) -> (DVec3, [DVec3; 3]) {
        let (middle, half) = ((self.low + self.high) / 2.0, (self.high - self.low) / 2.0);
        let wider = half + DVec3::splat(SLACK * self.low.abs().max(self.high.abs()).max_element());
        let at = |place: DVec3| self.axes[0] * place.x + self.axes[1] * place.y + self.axes[2] * place.z;
        (at(middle), [0, 1, 2].map(|axis| self.axes[axis] * wider[axis]))
    }

    /// The bounding volume of a tile.
    pub(super) fn json(&self) -> Value {
        let (middle, half) = self.middle_and_half();
        let numbers: Vec<f64> = [middle].into_iter().chain(half).flat_map(|v| v.to_array()).collect();
        json!({ "box": numbers })
    }
}
