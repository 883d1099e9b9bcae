//! Twin of `select.comp`: which vertices of a patch are awake.
//!
//! Every operation is a single-precision IEEE operation in the order of the shader, which marks them `precise`.

use crate::layout::{FrameView, PatchVertex};
use crate::wake::Wake;
use glam::Vec3;

/// Camera-relative position in lattice units: integers first.
#[inline]
pub fn relative(view: &FrameView, position: [i32; 3]) -> Vec3 {
    let difference = |k: usize| position[k].wrapping_sub(view.anchor[k]) as f32 - view.offset[k];
    Vec3::new(difference(0), difference(1), difference(2))
}

#[inline]
fn dot(a: Vec3, b: [f32; 3]) -> f32 {
    a.x * b[0] + a.y * b[1] + a.z * b[2]
}

/// A wake's distance in f32, exact.
#[inline]
fn distance(code: u32) -> f32 {
    let (exponent, mantissa) = (code >> 10, code & 1023);
    f32::from_bits((exponent + 127) << 23 | mantissa << 13)
}

/// Whether a grid vertex lies on one of the given sides (bits left, right, bottom, top).
#[inline]
pub fn on_sides(grid: u32, cells: u32, sides: u32) -> bool {
    let (i, j) = (grid % (cells + 1), grid / (cells + 1));
    (sides & 1 != 0 && i == 0) || (sides & 2 != 0 && i == cells) || (sides & 4 != 0 && j == 0) || (sides & 8 != 0 && j == cells)
}

/// Whether one vertex is awake.
#[inline]
pub fn is_awake(view: &FrameView, vertex: &PatchVertex, coarser_sides: u32) -> bool {
    let coarser = coarser_sides != 0 && on_sides(vertex.grid(), view.cells, coarser_sides);
    let code = if coarser { vertex.parent_coarser } else { vertex.grid_own } >> 16;
    if code == u32::from(Wake::ALWAYS.code()) {
        return true;
    }
    if code == 0 {
        return false;
    }
    let p = relative(view, vertex.position);
    let outside = view.planes.iter().map(|&n| dot(p, n)).fold(0.0f32, f32::max);
    let reach = view.scale * distance(code) - view.falloff * outside;
    let squared = p.x * p.x + p.y * p.y + p.z * p.z;
    reach > 0.0 && squared < reach * reach
}

/// Awake bits of the first `vertices.len()` vertices of a patch, 32 a word.
pub fn select(view: &FrameView, vertices: &[PatchVertex], coarser_sides: u32) -> Vec<u32> {
    let word = |chunk: &[PatchVertex]| {
        chunk.iter().enumerate().fold(0, |bits, (k, v)| bits | u32::from(is_awake(view, v, coarser_sides)) << k)
    };
    vertices.chunks(32).map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shader_wakes_equal_builder_wakes() {
        for code in 1..u16::MAX {
            assert_eq!(f64::from(distance(u32::from(code))), Wake::from_code(code).distance());
        }
    }
}
