//! Where the sea is: below its level, but not where layers keep it out. In: directions and heights. Out: metres above the sea.

use super::layer::Step;
use super::points::{Lane, Points, LANES};
use super::{GroundPoint, Terrain};
use crate::recipe::Recipe;
use glam::DVec3;

/// Metres above the sea that ground counts as where the sea is kept out wholly, and below it where it is not at all: deeper sea is all
/// the same to a picture.
const FIRM_M: f64 = 400.0;

/// Metres above the sea of ground that stands so much above its level, where the sea is kept out so firmly.
#[inline(always)]
pub(super) fn above_sea(above_level: f64, dry: f32) -> f64 {
    above_level.max((f64::from(dry) - 0.5) * (2.0 * FIRM_M))
}

impl Terrain {
    /// How firmly layers keep the sea out of each point, 0 to 1, with its border at a half; nothing where none does.
    #[inline(always)]
    pub(super) fn kept_dry(&self, p: &Points) -> Option<Lane> {
        let mut kept: Option<Lane> = None;
        for own in self.steps.iter().filter_map(|step| step.dry(p)) {
            let kept = kept.get_or_insert([0.0; LANES]);
            for i in 0..LANES {
                kept[i] = kept[i].max(own[i]);
            }
        }
        kept
    }

    /// Metres above the sea of each point: those above its level, or more where the sea is kept out. Nothing without a sea.
    pub fn above_sea(&self, points: &[GroundPoint]) -> Option<Vec<f64>> {
        let level = self.sea_level?;
        let mut above: Vec<f64> = points.iter().map(|point| point.height - level).collect();
        if self.lowest_dry().is_some() {
            for (points, above) in points.chunks(LANES).zip(above.chunks_mut(LANES)) {
                let kept = self.kept_dry(&self.points(points.len(), |i| points[i].direction));
                for (above, dry) in above.iter_mut().zip(kept.into_iter().flatten()) {
                    *above = above_sea(*above, dry);
                }
            }
        }
        Some(above)
    }

    /// Whether the sea is kept out of the ground in a unit direction.
    pub fn is_kept_dry(&self, direction: DVec3) -> bool {
        self.kept_dry(&self.points(1, |_| direction)).is_some_and(|kept| kept[0] > 0.5)
    }

    /// Metres above the datum of what lies uppermost in a unit direction where the ground is `ground_m` high: the ground, or the sea.
    /// The sea is that of a recipe with these layers.
    pub fn ground_or_sea(&self, recipe: &Recipe, direction: DVec3, ground_m: f64) -> f64 {
        let uppermost = recipe.ground_or_sea(ground_m);
        if uppermost > ground_m && self.is_kept_dry(direction) {
            ground_m
        } else {
            uppermost
        }
    }

    /// A height in metres that no ground out of which the sea is kept lies below, if it is kept out of any.
    pub fn lowest_dry(&self) -> Option<f64> {
        self.lowest_dry
    }

    /// See [`Terrain::lowest_dry`]: the lowest of layers that keep the sea out, and what others and edits may dig there.
    pub(super) fn find_lowest_dry(&self) -> Option<f64> {
        let lowest = self.steps.iter().filter_map(Step::lowest_dry).reduce(f64::min)?;
        let dug = self.steps.iter().map(Step::digs).sum::<f64>();
        let (low, high) = ((lowest + dug).max(self.layers_range.0), self.layers_range.1);
        Some(self.edits.bounds((low, high)).into_iter().fold(low, |low, edit| low.min(edit.0)) - 0.5)
    }
}
