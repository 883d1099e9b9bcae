//! Edits of the ground, in order, over the height of all layers. In: unit directions and their heights. Out: the heights changed;
//! past the reach of every edit they keep their bits.
//!
//! Near and far are told by chords: the squared distance between unit directions, which needs no square root and no angle. Which
//! edits a run of points may meet is asked of a tree of boxes (obvhs) that are wider than the edits by more than f32 rounds, so
//! the tree decides no bit, and thousands of edits cost what the few that are near cost.

use super::craters::{bowl, RIM};
use super::points::LANES;
use crate::recipe::{Edit, Shape};
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{builder::build_bvh2, Bvh2};
use obvhs::BvhBuildParams;
use std::time::Duration;
use terrane_heightfield::angles::sin_cos;

/// By how much boxes about unit directions are widened: sixteen times what f32 rounds.
const WIDENING: f64 = 1.0 / (1u32 << 20) as f64;

/// Room in the bounds of heights for rounding, in metres.
const BOUND_ROOM_M: f64 = 1e-3;

/// Share of a flattened site's squared radius that is level: the shoulder is the outer quarter of the radius.
const LEVEL_SHARE: f64 = 0.5625;

/// All edits of a planet.
pub(super) struct Edits {
    sites: Vec<Site>,
    tree: Bvh2,
}

struct Site {
    centre: DVec3,
    /// One over the squared radius, as a chord of the unit sphere.
    per_radius2: f64,
    /// Squared reach over squared radius.
    reach2: f64,
    /// Reach as a chord of the unit sphere.
    reach: f64,
    shape: Shape,
}

/// The direction of a site, the same bits on every machine.
pub(crate) fn centre(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (sin_cos(latitude_deg), sin_cos(longitude_deg));
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

impl Site {
    fn new(edit: &Edit, planet_m: f64) -> Self {
        let (radius, reach) = (edit.radius_m / planet_m, edit.reach_m() / planet_m);
        let relative = edit.reach_m() / edit.radius_m;
        Self {
            centre: centre(edit.latitude_deg, edit.longitude_deg),
            per_radius2: 1.0 / (radius * radius),
            reach2: relative * relative,
            reach,
            shape: edit.shape,
        }
    }

    /// The height at a squared distance of `t` squared radii, within reach.
    fn height(&self, before: f64, t: f64) -> f64 {
        match self.shape {
            Shape::Crater { depth_m, ground_m } => {
                let ground = ground_m.map_or(before, |ground_m| before + (ground_m - before) * erased(t));
                ground + depth_m * crater(t)
            }
            Shape::Flatten { height_m } => before + (height_m - before) * level(t),
            Shape::Raise { by_m } => before + by_m * (1.0 - t) * (1.0 - t),
        }
    }

    /// Bounds of the height after this edit, from those before.
    fn bounds(&self, (low, high): (f64, f64)) -> (f64, f64) {
        let (low, high) = match self.shape {
            Shape::Crater { depth_m, ground_m } => {
                let (low, high) = (low.min(ground_m.unwrap_or(low)), high.max(ground_m.unwrap_or(high)));
                (low - depth_m, high + depth_m * f64::from(RIM))
            }
            Shape::Flatten { height_m } => (low.min(height_m), high.max(height_m)),
            Shape::Raise { by_m } => (low + by_m.min(0.0), high + by_m.max(0.0)),
        };
        (low - BOUND_ROOM_M, high + BOUND_ROOM_M)
    }

    fn change(&self, directions: &[DVec3], heights: &mut [f64]) {
        for (direction, height) in directions.iter().zip(heights) {
            let off = *direction - self.centre;
            let t = off.dot(off) * self.per_radius2;
            if t < self.reach2 {
                *height = self.height(*height, t);
            }
        }
    }
}

/// A crater's height over its depth: the bowl of [`super::craters`], and ejecta that thin out as the cube of the distance (McGetchin,
/// Settle and Head 1973) and end smoothly at [`Edit::REACH`].
fn crater(t: f64) -> f64 {
    if t < 1.0 {
        return f64::from(bowl(t as f32, 0.0));
    }
    let way = (t - 1.0) / (Edit::REACH * Edit::REACH - 1.0);
    let end = 1.0 - way * way;
    f64::from(RIM) / (t * t.sqrt()) * (end * end)
}

/// How much of the old relief a crater erases: all in the middle, nothing from the rim on.
fn erased(t: f64) -> f64 {
    let left = 1.0 - t * t;
    if t < 1.0 {
        left * left
    } else {
        0.0
    }
}

/// How level a flattened site is: 1 inside, smoothly to 0 at its radius.
fn level(t: f64) -> f64 {
    let way = ((1.0 - t) / (1.0 - LEVEL_SHARE)).min(1.0);
    way * way * (3.0 - 2.0 * way)
}

impl Edits {
    pub(super) fn new(edits: &[Edit], planet_m: f64) -> Self {
        let sites: Vec<Site> = edits.iter().map(|edit| Site::new(edit, planet_m)).collect();
        let boxes: Vec<Aabb> = sites.iter().map(|s| widened(s.centre - s.reach, s.centre + s.reach)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::very_fast_build(), &mut Duration::default());
        Self { sites, tree }
    }

    /// Changes the heights of directions.
    pub(super) fn apply(&self, directions: &[DVec3], heights: &mut [f64]) {
        if self.sites.is_empty() {
            return;
        }
        let mut near = Vec::new();
        for (directions, heights) in directions.chunks(LANES).zip(heights.chunks_mut(LANES)) {
            self.find(directions, &mut near);
            for &site in &near {
                self.sites[site as usize].change(directions, heights);
            }
        }
    }

    /// The edits that may reach some of the directions, in order.
    fn find(&self, directions: &[DVec3], near: &mut Vec<u32>) {
        near.clear();
        let low = directions.iter().fold(DVec3::INFINITY, |low, &d| low.min(d));
        let high = directions.iter().fold(DVec3::NEG_INFINITY, |high, &d| high.max(d));
        self.tree.aabb_traverse(widened(low, high), |tree, node| {
            let node = &tree.nodes[node as usize];
            let found = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            near.extend_from_slice(&tree.primitive_indices[found]);
            true
        });
        near.sort_unstable();
    }

    /// Bounds of the heights within reach of each edit, after it and all before it; `layers` are those of the ground before all.
    /// Only edits that meet add up, so that a thousand craters side by side are no deeper than one.
    pub(super) fn bounds(&self, layers: (f64, f64)) -> Vec<(f64, f64)> {
        let mut bounds: Vec<(f64, f64)> = Vec::with_capacity(self.sites.len());
        for site in &self.sites {
            let meets = |earlier: &Site| earlier.centre.distance(site.centre) <= earlier.reach + site.reach + WIDENING;
            let before = self.sites.iter().zip(&bounds).filter(|(earlier, _)| meets(earlier));
            let before = before.fold(layers, |(low, high), (_, met)| (low.min(met.0), high.max(met.1)));
            bounds.push(site.bounds(before));
        }
        bounds
    }
}

fn widened(low: DVec3, high: DVec3) -> Aabb {
    Aabb::new((low - WIDENING).as_vec3a(), (high + WIDENING).as_vec3a())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLANET_M: f64 = 1e5;

    fn edit(latitude_deg: f64, longitude_deg: f64, radius_m: f64, shape: Shape) -> Edit {
        Edit { latitude_deg, longitude_deg, radius_m, shape }
    }

    /// Height at so many metres (chord) from the middle of one edit of level ground at 10 m.
    fn section(shape: Shape, metres: f64) -> f64 {
        let one = edit(20.0, 30.0, 100.0, shape);
        let (centre, edits) = (centre(20.0, 30.0), Edits::new(&[one], PLANET_M));
        let chord = metres / PLANET_M;
        let half = 0.5 * chord;
        let (along, back) = (chord * (1.0 - half * half).sqrt(), 1.0 - 2.0 * half * half);
        let mut height = [10.0];
        edits.apply(&[centre * back + centre.any_orthonormal_vector() * along], &mut height);
        height[0]
    }

    const SHAPES: [Shape; 3] =
        [Shape::Crater { depth_m: 40.0, ground_m: Some(12.0) }, Shape::Flatten { height_m: 25.0 }, Shape::Raise { by_m: -7.0 }];

    #[test]
    fn middles_of_edits_are_as_asked() {
        for (shape, expected) in SHAPES.into_iter().zip([-28.0, 25.0, 3.0]) {
            assert!((section(shape, 0.0) - expected).abs() < 1e-9, "{shape:?}: {}", section(shape, 0.0));
        }
        assert!((section(SHAPES[0], 100.0) - 20.0).abs() < 1e-3, "the rim");
        assert!((section(SHAPES[1], 74.0) - 25.0).abs() < 1e-9, "the level part");
    }

    #[test]
    fn ground_out_of_reach_keeps_its_bits() {
        for shape in SHAPES {
            let reach = edit(0.0, 0.0, 100.0, shape).reach_m();
            assert_eq!(section(shape, reach * 1.000_001).to_bits(), 10.0f64.to_bits(), "{shape:?}");
            assert_ne!(section(shape, reach * 0.9).to_bits(), 10.0f64.to_bits(), "{shape:?} does not reach as far as it says");
        }
    }

    #[test]
    fn edges_of_edits_are_smooth() {
        for shape in SHAPES {
            let reach = edit(0.0, 0.0, 100.0, shape).reach_m();
            let slope = |x: f64| (section(shape, x + 0.01) - section(shape, x)) / 0.01;
            let mut sharpest: f64 = 0.0;
            for k in 1..=(2 * reach as i32 + 20) {
                let x = f64::from(k) / 2.0 - 0.3;
                let rim = matches!(shape, Shape::Crater { .. }) && (98.0..102.0).contains(&x);
                if !rim {
                    sharpest = sharpest.max((slope(x + 0.5) - slope(x)).abs());
                }
            }
            assert!(sharpest < 0.1, "{shape:?}: the slope jumps by {sharpest} within half a metre");
        }
        let outer = section(SHAPES[0], 150.0) - 10.0;
        assert!((outer / 10.0 * 1.5f64.powi(3) - 0.95).abs() < 0.02, "ejecta at one and a half radii: {outer} m");
    }

    /// Many edits of all sizes, and points near some of them and elsewhere.
    fn crowd() -> (Vec<Edit>, Vec<DVec3>) {
        let draw = |k: u64| super::super::noise::unit(super::super::noise::mix(k));
        let one = |k: u64| {
            let radius = 30.0 * 4000.0f64.powf(draw(k * 5 + 1) * draw(k * 5 + 4)).min(1000.0);
            let shape = SHAPES[(k % 3) as usize];
            edit(180.0 * draw(k * 5 + 2) - 90.0, 360.0 * draw(k * 5 + 3) - 180.0, radius, shape)
        };
        let edits: Vec<Edit> = (1..=3000).map(one).collect();
        let near = |(k, e): (usize, &Edit)| {
            let spacing = [0.02, 0.4, 30.0][k % 3] * e.radius_m / PLANET_M;
            let middle = centre(e.latitude_deg, e.longitude_deg);
            let (east, north) = middle.any_orthonormal_pair();
            (0..LANES).map(move |i| (middle + east * (spacing * (i % 8) as f64) + north * (spacing * (i / 8) as f64)).normalize())
        };
        let points = edits.iter().enumerate().step_by(37).flat_map(near).collect();
        (edits, points)
    }

    #[test]
    fn the_tree_finds_all_edits_in_order() {
        let (edits, points) = crowd();
        let all = Edits::new(&edits, PLANET_M);
        let mut found = vec![1.0; points.len()];
        all.apply(&points, &mut found);
        let mut expected = vec![1.0; points.len()];
        all.sites.iter().for_each(|site| site.change(&points, &mut expected));
        let bits = |heights: &[f64]| heights.iter().map(|h| h.to_bits()).collect::<Vec<u64>>();
        assert_eq!(bits(&found), bits(&expected));
        let mut backwards = vec![1.0; points.len()];
        all.sites.iter().rev().for_each(|site| site.change(&points, &mut backwards));
        assert_ne!(bits(&backwards), bits(&expected), "the order never matters: nothing is shown");
        let mut near = Vec::new();
        let asked: usize = points.chunks(LANES).map(|run| (all.find(run, &mut near), near.len()).1).sum();
        assert!(asked * 20 < edits.len() * points.len() / LANES, "{asked} edits looked at: the tree is of no use");
    }

    #[test]
    fn heights_stay_within_their_bounds() {
        let (edits, points) = crowd();
        let all = Edits::new(&edits, PLANET_M);
        let bounds = all.bounds((1.0, 1.0));
        let (low, high) = bounds.iter().fold((1.0f64, 1.0f64), |(l, h), b| (l.min(b.0), h.max(b.1)));
        let mut heights = vec![1.0; points.len()];
        all.apply(&points, &mut heights);
        assert!(heights.iter().all(|h| (low..=high).contains(h)));
        let deepest = 40.0 * 1000.0;
        assert!(low > -0.1 * deepest, "{low}: edits that do not meet add up");
    }
}
