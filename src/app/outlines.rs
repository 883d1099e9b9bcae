//! Lines over the picture that show what else cannot be seen: borders of patches, and the frustum of a frozen selection.
//!
//! In: a scene and a camera. Out: lines in pixels. They are not hidden by the ground, only by the planet's round.

use super::inspection::Link;
use super::surface::{DrawnSurface, Surface};
use crate::scene::Scene;
use egui::Color32;
use glam::DVec3;
use terrane_planet::draw::camera_path::CameraPath;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction;

/// Parts that a patch's side is drawn in; a power of two.
const PARTS: u32 = 8;
/// Parts that a camera path is drawn in.
const PATH_PARTS: u32 = 200;
/// Most patches whose borders are drawn.
const MOST_PATCHES: usize = 1500;
/// How far a frustum's edges reach that meet no ground, in distances from its camera to the planet's centre.
const REACH: f64 = 2.0;
/// Metres by which lines float above the ground.
const LIFT: f64 = 0.5;

/// Colour of chains of parents.
const CHAIN: Color32 = Color32::from_rgb(255, 110, 220);

/// Points in pixels, joined in order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) points: Vec<[f32; 2]>,
    pub(super) color: Color32,
    pub(super) width: f32,
}

/// What a selection was frozen with.
pub(super) struct FrozenView {
    pub(super) view: View,
    pub(super) leaves: Vec<PatchId>,
}

/// Where a point is seen, in pixels. None behind the camera.
pub(super) fn project(camera: &Camera, point: DVec3) -> Option<[f32; 2]> {
    let away = point - camera.position;
    let depth = away.dot(camera.forward);
    if depth <= 0.0 {
        return None;
    }
    let (h, v) = camera.half_extents();
    let (x, y) = (away.dot(camera.right()) / (depth * h), away.dot(camera.up) / (depth * v));
    let [width, height] = camera.size.map(f64::from);
    Some([(0.5 * (1.0 + x) * width) as f32, (0.5 * (1.0 - y) * height) as f32])
}

/// Collects lines of a picture.
pub(super) struct Outlines<'a> {
    scene: &'a Scene,
    surface: DrawnSurface<'a>,
    camera: Camera,
    /// Cosine of the angle at the planet's centre beyond which a ball of its radius hides what is on it.
    horizon: f64,
    pub(super) lines: Vec<Line>,
}

impl<'a> Outlines<'a> {
    /// Over the sea, or its floor.
    pub(super) fn new(scene: &'a Scene, wet: bool, camera: Camera) -> Outlines<'a> {
        let (lowest, highest) = scene.planet().terrain.height_range();
        let (radius, highest) = (scene.planet().recipe.radius + lowest, highest - lowest);
        let dip = |height: f64| (radius / (radius + height.max(1.0))).min(1.0).acos();
        let horizon = (dip(camera.position.length() - radius) + dip(highest)).cos();
        Outlines { scene, surface: DrawnSurface::of_scene(scene, wet), camera, horizon, lines: Vec::new() }
    }

    /// The border of a patch, on the ground that is drawn.
    pub(super) fn add_patch(&mut self, id: PatchId, color: Color32, width: f32) {
        let last = PARTS as i32;
        let corners = [(0, 0), (last, 0), (last, last), (0, last), (0, 0)];
        let side = |[(a, b), (c, d)]: [(i32, i32); 2]| (0..last).map(move |k| (a + (c - a) * k / last, b + (d - b) * k / last));
        let around = corners.windows(2).flat_map(|ends| side([ends[0], ends[1]]));
        let points: Vec<Option<[f32; 2]>> =
            around.chain([(0, 0)]).map(|(a, b)| self.on_ground(direction(id.point(a, b, PARTS)))).collect();
        self.add_seen(&points, color, width);
    }

    /// What a frozen selection drew, and the frustum that it was seen in.
    pub(super) fn add_frozen(&mut self, frozen: &FrozenView) {
        for id in frozen.leaves.iter().take(MOST_PATCHES) {
            self.add_patch(*id, Color32::from_rgba_unmultiplied(255, 220, 120, 150), 1.0);
        }
        let from = &frozen.view.camera;
        let (h, v) = from.half_extents();
        let ends = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let ray = (from.forward + from.right() * (h * x) + from.up * (v * y)).normalize();
            let hit = self.scene.ground().known.raycast(from.position, ray).map(|hit| hit.position);
            hit.unwrap_or(from.position + ray * (REACH * from.position.length()))
        });
        let color = Color32::from_rgb(120, 200, 255);
        for (k, end) in ends.into_iter().enumerate() {
            self.add_straight(from.position, end, color);
            self.add_straight(end, ends[(k + 1) % 4], color);
        }
    }

    /// A chain of parents: strong from vertices that are awake, and faint from those that sleep and are drawn as the first that is not.
    pub(super) fn add_chain(&mut self, chain: &[Link]) {
        for ends in chain.windows(2) {
            let [from, to] = [0, 1].map(|k| ends[k].position + ends[k].position.normalize() * LIFT);
            if !self.is_behind_planet(from) && !self.is_behind_planet(to) {
                let color = if ends[0].weight.is_some() { CHAIN } else { CHAIN.gamma_multiply(0.5) };
                self.add_straight(from, to, color);
            }
        }
        // The vertex that it begins with.
        let Some([x, y]) = chain.first().and_then(|first| project(&self.camera, first.position)) else { return };
        let points = (0..=8).map(|k| f32::to_radians(45.0 * k as f32).sin_cos()).map(|(s, c)| [x + 4.0 * c, y + 4.0 * s]);
        self.lines.push(Line { points: points.collect(), color: CHAIN, width: 2.0 });
    }

    /// A circle on the ground about a site, of a radius in metres.
    pub(super) fn add_circle(&mut self, site: DVec3, radius_m: f64, color: Color32) {
        let (side, angle) = (site.any_orthonormal_vector(), radius_m / self.scene.planet().recipe.radius);
        let other = site.cross(side);
        let points: Vec<Option<[f32; 2]>> = (0..=64)
            .map(|k| {
                let (sine, cosine) = (f64::from(k) * std::f64::consts::TAU / 64.0).sin_cos();
                self.on_ground((site * angle.cos() + (side * cosine + other * sine) * angle.sin()).normalize())
            })
            .collect();
        self.add_seen(&points, color, 2.0);
    }

    /// A camera path.
    pub(super) fn add_path(&mut self, path: &CameraPath) {
        let (begin, end) = path.span();
        let planet = self.scene.planet();
        let points: Vec<Option<[f32; 2]>> = (0..=PATH_PARTS)
            .map(|k| {
                let waypoint = path.at(begin + (end - begin) * f64::from(k) / f64::from(PATH_PARTS));
                let point = planet.position_of(waypoint.up, waypoint.stand);
                project(&self.camera, point).filter(|_| !self.is_behind_planet(point))
            })
            .collect();
        self.add_seen(&points, Color32::from_rgb(140, 255, 160), 2.0);
    }

    /// Whether the planet, as a ball, hides a point that may be high above it.
    fn is_behind_planet(&self, point: DVec3) -> bool {
        let (from, ray) = (self.camera.position, (point - self.camera.position).normalize());
        let nearest = -from.dot(ray);
        let passes =
            (from + ray * nearest).length() > self.scene.planet().recipe.radius + self.scene.planet().terrain.height_range().0;
        !passes && nearest > 0.0 && nearest < point.distance(from)
    }

    fn on_ground(&self, direction: DVec3) -> Option<[f32; 2]> {
        if direction.dot(self.camera.position.normalize()) < self.horizon {
            return None;
        }
        project(&self.camera, direction * (self.surface.radius(direction) + LIFT))
    }

    /// A straight line, cut where it comes before the camera.
    fn add_straight(&mut self, from: DVec3, to: DVec3, color: Color32) {
        let points: Vec<Option<[f32; 2]>> =
            (0..=PARTS).map(|k| project(&self.camera, from.lerp(to, f64::from(k) / f64::from(PARTS)))).collect();
        self.add_seen(&points, color, 1.5);
    }

    /// The runs of points that can be seen.
    fn add_seen(&mut self, points: &[Option<[f32; 2]>], color: Color32, width: f32) {
        for run in points.split(Option::is_none).filter(|run| run.len() > 1) {
            self.lines.push(Line { points: run.iter().flatten().copied().collect(), color, width });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::{pose, LENS};
    use super::*;

    #[test]
    fn what_a_pixel_looks_at_is_projected_onto_it() {
        let viewer = pose(3e5, 30.0, -50.0);
        let camera = viewer.camera(&LENS);
        for pixel in [[400.0, 300.0], [13.0, 588.0], [799.0, 0.5]] {
            let [x, y] = project(&camera, viewer.position + viewer.ray(&LENS, pixel) * 1234.5).unwrap();
            assert!((f64::from(x) - pixel[0]).abs() < 1e-2 && (f64::from(y) - pixel[1]).abs() < 1e-2, "{x} {y}");
        }
        assert_eq!(project(&camera, viewer.position - viewer.ray(&LENS, [400.0, 300.0])), None);
    }
}
