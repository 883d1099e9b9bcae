//! A picture to draw on: rectangles, triangles with depth, and text. Drawn finer than shown and averaged at the end, which
//! smooths every edge.

use font8x8::legacy::BASIC_LEGACY;
use glam::{DVec2, DVec3, Vec3};

/// Samples a pixel along each axis.
pub(crate) const FINER: usize = 3;

/// Shades of red, of green and of blue.
const SHADES: f32 = 32.0;

/// A picture under way; positions and lengths are in shown pixels, from the top left.
pub(crate) struct Canvas {
    /// Width and height in shown pixels.
    pub(crate) size: [usize; 2],
    colors: Vec<Vec3>,
    depths: Vec<f32>,
}

impl Canvas {
    /// An empty picture.
    pub(crate) fn new(size: [usize; 2], background: Vec3) -> Canvas {
        let samples = size[0] * size[1] * FINER * FINER;
        Canvas { size, colors: vec![background; samples], depths: vec![f32::INFINITY; samples] }
    }

    /// Fills a rectangle from its top left corner, over everything.
    pub(crate) fn rectangle(&mut self, [left, top]: [f64; 2], [width, height]: [f64; 2], color: Vec3) {
        let finer = FINER as f64;
        let range = |from: f64, length: f64, most: usize| {
            ((from * finer).round().max(0.0) as usize)..((from + length) * finer).round().clamp(0.0, most as f64) as usize
        };
        let [columns, rows] = self.size.map(|s| s * FINER);
        for y in range(top, height, rows) {
            for x in range(left, width, columns) {
                self.colors[y * columns + x] = color;
            }
        }
    }

    /// Writes one line of ASCII with its top left corner at a position; letters are `scale` × 8 pixels.
    pub(crate) fn text(&mut self, [left, top]: [f64; 2], scale: f64, text: &str, color: Vec3) {
        for (index, letter) in text.bytes().enumerate() {
            let rows = BASIC_LEGACY.get(letter as usize).copied().unwrap_or_default();
            for (y, row) in rows.into_iter().enumerate() {
                for x in (0..8).filter(|x| row >> x & 1 == 1) {
                    let corner = [left + scale * (8 * index + x) as f64, top + scale * y as f64];
                    self.rectangle(corner, [scale; 2], color);
                }
            }
        }
    }

    /// Draws a triangle where nothing nearer is: x and y in pixels, z the distance. `paint` is given the distances in pixels from
    /// the three sides (the first is that opposite the first corner).
    pub(crate) fn triangle(&mut self, corners: [DVec3; 3], paint: impl Fn([f64; 3]) -> Vec3) {
        let finer = FINER as f64;
        let [a, b, c] = corners.map(|p| DVec3::new(p.x * finer, p.y * finer, p.z));
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        let [columns, rows] = self.size.map(|s| (s * FINER) as f64);
        let range = |values: [f64; 3], most: f64| {
            let low = values.into_iter().fold(f64::INFINITY, f64::min).floor().max(0.0);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil().min(most - 1.0);
            low as usize..=high.max(0.0) as usize
        };
        if area == 0.0 {
            return;
        }
        for y in range([a.y, b.y, c.y], rows) {
            for x in range([a.x, b.x, c.x], columns) {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weight = |p: DVec3, q: DVec3| (q - p).truncate().perp_dot(at - p.truncate()) / area;
                let shares = [weight(b, c), weight(c, a), weight(a, b)];
                let depth = (shares[0] * a.z + shares[1] * b.z + shares[2] * c.z) as f32;
                let sample = y * self.size[0] * FINER + x;
                if shares.iter().all(|&s| s >= 0.0) && depth < self.depths[sample] {
                    let heights = [(b, c), (c, a), (a, b)].map(|(p, q)| area.abs() / (q - p).truncate().length() / finer);
                    self.depths[sample] = depth;
                    self.colors[sample] = paint([0, 1, 2].map(|k| shares[k] * heights[k]));
                }
            }
        }
    }

    /// The picture as RGBA bytes. Colors are rounded to [`SHADES`] a channel, which makes a PNG a third smaller and does not show
    /// on flat facets.
    pub(crate) fn into_rgba(self) -> Vec<u8> {
        let [columns, rows] = self.size;
        let mut bytes = Vec::with_capacity(4 * columns * rows);
        for y in 0..rows {
            for x in 0..columns {
                let samples = (0..FINER * FINER).map(|k| (y * FINER + k / FINER) * columns * FINER + x * FINER + k % FINER);
                let mean = samples.map(|s| self.colors[s]).sum::<Vec3>() / (FINER * FINER) as f32;
                let shade = |v: f32| (v.clamp(0.0, 1.0) * (SHADES - 1.0)).round() / (SHADES - 1.0);
                bytes.extend(mean.to_array().map(|v| (shade(v) * 255.0).round() as u8));
                bytes.push(255);
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn red(rgba: &[u8], columns: usize, x: usize, y: usize) -> u8 {
        rgba[4 * (y * columns + x)]
    }

    #[test]
    fn nearer_triangles_hide_farther_ones_in_either_order() {
        let corners = |z: f64| [(0.0, 0.0), (20.0, 0.0), (0.0, 20.0)].map(|(x, y)| DVec3::new(x, y, z));
        for order in [[1.0, 2.0], [2.0, 1.0]] {
            let mut canvas = Canvas::new([8, 8], Vec3::ZERO);
            for z in order {
                canvas.triangle(corners(z), |_| Vec3::splat(1.0 / z as f32));
            }
            assert_eq!(red(&canvas.into_rgba(), 8, 2, 2), 255);
        }
    }

    #[test]
    fn edges_are_smoothed() {
        let mut canvas = Canvas::new([8, 8], Vec3::ZERO);
        canvas.rectangle([0.0, 0.0], [2.0 + 1.0 / 3.0, 8.0], Vec3::ONE);
        let rgba = canvas.into_rgba();
        assert_eq!([1, 2, 3].map(|x| red(&rgba, 8, x, 4)), [255, 82, 0]);
    }

    #[test]
    fn triangles_know_the_distance_from_their_sides_in_pixels() {
        let mut canvas = Canvas::new([30, 30], Vec3::ZERO);
        let corners = [(0.0, 0.0), (30.0, 0.0), (0.0, 30.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
        canvas.triangle(corners, |[_, west, north]| Vec3::splat(if north < 2.0 || west < 2.0 { 1.0 } else { 0.5 }));
        let rgba = canvas.into_rgba();
        assert_eq!([(1, 9), (2, 9), (9, 1), (9, 2)].map(|(x, y)| red(&rgba, 30, x, y)), [255, 132, 255, 132]);
    }
}
