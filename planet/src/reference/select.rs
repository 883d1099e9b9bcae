//! Twin of `select.comp`: which vertices of a patch are awake, and where they are drawn.
//!
//! Every operation is a single-precision IEEE operation in the order of the shader, which marks them `precise`.

use super::position::{drawn_position, relative};
use crate::draw::layout::{high16, DrawnVertex, FrameView, PatchVertex};
use crate::globe::patch::Side;
use crate::mesh::wake::{Wake, MANTISSA_BITS};
use glam::Vec3;

/// What a view selects of a patch, or of a prefix of its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selected {
    /// Awake bits, 32 a word.
    pub awake: Vec<u32>,
    /// Where each vertex is drawn.
    pub drawn_positions: Vec<DrawnVertex>,
}

#[inline]
fn dot(a: Vec3, b: [f32; 3]) -> f32 {
    a.x * b[0] + a.y * b[1] + a.z * b[2]
}

/// A wake's distance from its 16 bits in f32, exact.
#[inline]
fn wake_distance(code: u32) -> f32 {
    f32::from_bits((code << (f32::MANTISSA_DIGITS - 1 - MANTISSA_BITS)) + 1.0f32.to_bits())
}

/// Whether a grid vertex lies on one of the given sides (bits left, right, bottom, top).
#[inline]
pub fn on_sides(grid: u32, cells: u32, sides: u32) -> bool {
    let (i, j) = (grid % (cells + 1), grid / (cells + 1));
    let on = |side: Side| sides & u32::from(side.bit()) != 0;
    (on(Side::Left) && i == 0) || (on(Side::Right) && i == cells) || (on(Side::Bottom) && j == 0) || (on(Side::Top) && j == cells)
}

/// The morph weight (see [`super::position`]) of a vertex that is awake; `None` if it sleeps.
#[inline]
pub fn morph_weight(view: &FrameView, vertex: &PatchVertex, coarser_sides: u32) -> Option<f32> {
    let coarser = coarser_sides != 0 && on_sides(vertex.grid(), view.cells, coarser_sides);
    let code = high16(if coarser { vertex.parent_coarser_wake } else { vertex.grid_wake });
    if code == u32::from(Wake::ALWAYS.code()) {
        return Some(0.0);
    }
    if code == u32::from(Wake::ASLEEP.code()) {
        return None;
    }
    let wake = wake_distance(code);
    let p = relative(view, vertex.position);
    let outside = view.planes.iter().map(|&n| dot(p, n)).fold(0.0f32, f32::max);
    let falloff = view.falloff * outside;
    let reach = view.reach * wake - falloff;
    let squared = p.x * p.x + p.y * p.y + p.z * p.z;
    if reach <= 0.0 || squared >= reach * reach {
        return None;
    }
    let oriented = if view.height_weight > 0.0 { oriented_distance(view, p) } else { 0.0 };
    if oriented >= reach {
        return None;
    }
    let distance = squared.sqrt().max(oriented);
    let slide = ((distance + falloff) / wake - view.scale) * view.morph_rate;
    Some(slide.clamp(0.0, 1.0))
}

/// The orientation term's part of the selection distance, see [`crate::draw::orientation`].
#[inline]
fn oriented_distance(view: &FrameView, p: Vec3) -> f32 {
    let up = view.up;
    let below = -dot(p, up);
    let across = Vec3::new(p.y * up[2] - p.z * up[1], p.z * up[0] - p.x * up[2], p.x * up[1] - p.y * up[0]);
    let aside = (across.x * across.x + across.y * across.y + across.z * across.z).sqrt();
    view.height_weight * below - view.side_weight * aside
}

/// Selects among the first `vertices.len()` vertices of a patch.
pub fn select(view: &FrameView, vertices: &[PatchVertex], coarser_sides: u32) -> Selected {
    let mut selected =
        Selected { awake: vec![0; vertices.len().div_ceil(32)], drawn_positions: Vec::with_capacity(vertices.len()) };
    for (k, vertex) in vertices.iter().enumerate() {
        let weight = morph_weight(view, vertex, coarser_sides);
        selected.awake[k / 32] |= u32::from(weight.is_some()) << (k % 32);
        let position = drawn_position(view, vertices, k as u32, weight.unwrap_or(0.0)).to_array();
        selected.drawn_positions.push(DrawnVertex { position, weight: weight.unwrap_or(1.0) });
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::layout::pair;
    use crate::draw::view::{Camera, View};
    use crate::globe::lattice::Lattice;
    use crate::mesh::wake::MORPH_REACH;
    use glam::DVec3;

    /// A view, and a vertex ahead of its camera at `share` of the distance at which the vertex wakes.
    fn ahead(share: f64) -> (View, PatchVertex) {
        let camera = Camera::looking(DVec3::new(6.4e6, 0.0, 0.0), 0.0, -90.0, 1.0, [1280, 720]);
        let view = View::new(camera, &Lattice::new(6.371e6, 9e3), 128, 0.7);
        let wake = Wake::round_up(1e5);
        let position = view.eye + view.camera.forward * (share * view.scale * wake.distance());
        let vertex = PatchVertex {
            position: position.round().as_ivec3().to_array(),
            grid_wake: pair(0, wake.code()),
            ..Default::default()
        };
        (view, vertex)
    }

    #[test]
    fn a_vertex_wakes_in_its_parents_position_and_is_in_its_own_at_its_wake() {
        let weight = |share: f64| {
            let (view, vertex) = ahead(share);
            morph_weight(&view.gpu, &vertex, 0)
        };
        assert_eq!([0.2, 0.9, 0.9999].map(weight), [Some(0.0); 3]);
        let half = weight(1.0 + (MORPH_REACH - 1.0) / 2.0).unwrap();
        assert!((half - 0.5).abs() < 1e-3, "{half}");
        assert!(weight(MORPH_REACH - 1e-5).unwrap() > 0.999 && weight(MORPH_REACH + 1e-5).is_none());
    }

    #[test]
    fn without_geomorphs_a_vertex_is_in_its_own_position_or_asleep() {
        let weight = |share: f64| {
            let (view, vertex) = ahead(share);
            morph_weight(&view.without_geomorphs().gpu, &vertex, 0)
        };
        assert_eq!((weight(0.9999), weight(1.0001)), (Some(0.0), None));
    }

    #[test]
    fn shader_wakes_equal_builder_wakes() {
        for code in 1..u16::MAX {
            assert_eq!(f64::from(wake_distance(u32::from(code))), Wake::from_code(code).distance());
        }
    }
}
