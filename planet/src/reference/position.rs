//! Twin of `drawn_position` in `select.comp`: where vertices are drawn.
//!
//! A vertex that wakes comes out of its parent's position (Hoppe's geomorph, 1996): its *morph weight* falls from 1, its parent's
//! position, to 0, its own, while the viewer comes from `reach` to `scale` times its wake. Its parent stands still meanwhile.

use crate::draw::layout::{FrameView, PatchVertex};
use glam::{DVec3, IVec3, Vec3};

/// Camera-relative position in lattice units: integers first.
#[inline]
pub fn relative(view: &FrameView, position: [i32; 3]) -> Vec3 {
    let difference = |k: usize| position[k].wrapping_sub(view.anchor[k]) as f32 - view.offset[k];
    Vec3::new(difference(0), difference(1), difference(2))
}

/// Camera-relative position in lattice units at which a vertex is drawn that has some morph weight.
#[inline]
pub fn drawn_position(view: &FrameView, vertices: &[PatchVertex], v: u32, weight: f32) -> Vec3 {
    let own = relative(view, vertices[v as usize].position);
    if weight == 0.0 {
        return own;
    }
    let parent = relative(view, vertices[vertices[v as usize].parent() as usize].position);
    own + (parent - own) * weight
}

/// The same position from the planet's centre, before any of it is rounded to f32.
pub fn exact_position(vertices: &[PatchVertex], v: u32, weight: f32) -> DVec3 {
    let own = position(vertices, v).as_dvec3();
    if weight == 0.0 {
        return own;
    }
    own.lerp(position(vertices, vertices[v as usize].parent()).as_dvec3(), f64::from(weight))
}

fn position(vertices: &[PatchVertex], v: u32) -> IVec3 {
    IVec3::from_array(vertices[v as usize].position)
}
