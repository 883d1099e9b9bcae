//! A triangle surface as a block of ground in slight perspective: shaded facets, their edges on top, and cut walls below.

use super::canvas::Canvas;
use glam::{DVec2, DVec3, Vec3};
use std::collections::HashSet;
use terrane_heightfield::TriangleSurface;

/// Where the block is looked at from, as a direction: from the south-south-west and above.
const TOWARDS_EYE: DVec3 = DVec3::new(-0.42, -0.78, 0.62);

/// Distance of the eye from the block's centre, in its widths.
const EYE_DISTANCE: f64 = 3.2;

/// Width of the block in the picture, in its frame's width.
const FILL: f64 = 0.80;

/// Light comes from the west, a little towards the eye.
const TOWARDS_LIGHT: DVec3 = DVec3::new(-0.74, -0.18, 0.65);

/// Color of the ground by height, from the lowest to the highest.
const TINTS: [Vec3; 4] =
    [Vec3::new(0.42, 0.60, 0.52), Vec3::new(0.70, 0.74, 0.55), Vec3::new(0.86, 0.76, 0.60), Vec3::new(0.97, 0.95, 0.92)];

/// Color of the walls.
const WALL: Vec3 = Vec3::new(0.55, 0.50, 0.46);

/// Color of the edges.
const INK: Vec3 = Vec3::new(0.10, 0.12, 0.16);

/// A frame of the picture and what of the world fills it; the same for all meshes of a sheet.
pub(crate) struct Frame {
    /// Top left corner in pixels.
    pub(crate) corner: [f64; 2],
    /// Width and height in pixels.
    pub(crate) size: [f64; 2],
    /// Width of the ground, in samples.
    pub(crate) width: f64,
    /// Lowest and highest ground.
    pub(crate) heights: [f64; 2],
}

impl Frame {
    /// Draws a surface.
    pub(crate) fn draw(&self, canvas: &mut Canvas, surface: &TriangleSurface) {
        // Fewer pixels for the edges of many faces, or they would be all there is to see.
        let half_line = (0.62 - 0.065 * (surface.faces.len() as f64 / 100.0).max(1.0).log2()).max(0.3);
        for face in &surface.faces {
            let corners = face.map(|v| surface.positions[v as usize]);
            let color = self.facet_color(corners);
            let edge = color.lerp(INK, 0.68);
            let paint = |sides: [f64; 3]| if sides.iter().any(|&side| side < half_line) { edge } else { color };
            canvas.triangle(corners.map(|p| self.project(p)), paint);
        }
        for [from, to] in border_edges(surface) {
            self.draw_wall(canvas, from, to);
        }
    }

    fn draw_wall(&self, canvas: &mut Canvas, from: DVec3, to: DVec3) {
        let foot = self.heights[0] - 0.07 * self.width;
        let outwards = DVec2::new(to.y - from.y, from.x - to.x).normalize_or_zero();
        let shade = 0.72 + 0.28 * outwards.dot(TOWARDS_LIGHT.truncate()).max(0.0) as f32;
        let [a, b, c, d] = [from, to, to.with_z(foot), from.with_z(foot)].map(|p| self.project(p));
        for triangle in [[a, b, c], [a, c, d]] {
            canvas.triangle(triangle, |_| WALL * shade);
        }
    }

    fn facet_color(&self, [a, b, c]: [DVec3; 3]) -> Vec3 {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let light = normal.dot(TOWARDS_LIGHT.normalize()).max(0.0) as f32;
        let [low, high] = self.heights;
        let height = (((a.z + b.z + c.z) / 3.0 - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let scaled = height * (TINTS.len() - 1) as f64;
        let below = (scaled as usize).min(TINTS.len() - 2);
        let tint = TINTS[below].lerp(TINTS[below + 1], (scaled - below as f64) as f32);
        // Shadows are cool, light is warm.
        tint * (Vec3::new(0.34, 0.38, 0.46) + light * Vec3::new(0.80, 0.74, 0.62))
    }

    /// Pixel and distance of a position.
    fn project(&self, position: DVec3) -> DVec3 {
        let back = TOWARDS_EYE.normalize();
        let right = DVec3::Z.cross(back).normalize();
        let up = back.cross(right);
        // The walls reach below the lowest ground.
        let centre = DVec3::new(self.width / 2.0, self.width / 2.0, self.heights[0] - 0.02 * self.width);
        let seen = position - centre;
        let distance = EYE_DISTANCE * self.width - seen.dot(back);
        // The block's diagonal, seen from its distance, fills the frame's width.
        let zoom = FILL * self.size[0] / (1.3 * self.width) * EYE_DISTANCE * self.width / distance;
        DVec3::new(
            self.corner[0] + self.size[0] / 2.0 + zoom * seen.dot(right),
            self.corner[1] + self.size[1] / 2.0 - zoom * seen.dot(up),
            distance,
        )
    }
}

/// Edges with a face on one side only, in the direction of that face.
fn border_edges(surface: &TriangleSurface) -> Vec<[DVec3; 2]> {
    let directed = || surface.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let all: HashSet<(u32, u32)> = directed().collect();
    let border = directed().filter(|&(a, b)| !all.contains(&(b, a)));
    border.map(|(a, b)| [a, b].map(|v| surface.positions[v as usize])).collect()
}
