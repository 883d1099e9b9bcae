//! Twin of `emit.comp`: the triangles of a patch that this view draws.

use crate::draw::layout::{DrawnVertex, FrameView, BACK_SLACK, CULL_BACK, CULL_FRUSTUM};
use glam::Vec3;

/// Triangles of an index level with every corner replaced by the vertex it is drawn as; degenerate and culled ones dropped.
pub fn emit(view: &FrameView, triangles: &[[u16; 3]], resolved: &[u32], drawn_positions: &[DrawnVertex]) -> Vec<[u32; 3]> {
    let drawn = |t: &[u16; 3]| t.map(|v| resolved[usize::from(v)]);
    let keep = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a && !is_culled(view, drawn_positions, [a, b, c]);
    triangles.iter().map(drawn).filter(keep).collect()
}

fn is_culled(view: &FrameView, drawn_positions: &[DrawnVertex], triangle: [u32; 3]) -> bool {
    if view.culling == 0 {
        return false;
    }
    let [a, b, c] = triangle.map(|v| Vec3::from_array(drawn_positions[v as usize].position));
    let beyond = |n: &[f32; 3]| [a, b, c].iter().all(|p| p.x * n[0] + p.y * n[1] + p.z * n[2] > 0.0);
    (view.culling & CULL_FRUSTUM != 0 && view.planes.iter().any(beyond)) || (view.culling & CULL_BACK != 0 && faces_away(a, b, c))
}

/// Whether the eye lies on the inner side of the triangle's plane, by more than rounding could pretend.
fn faces_away(a: Vec3, b: Vec3, c: Vec3) -> bool {
    let (u, v) = (b - a, c - a);
    let normal = Vec3::new(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    let height = normal.x * a.x + normal.y * a.y + normal.z * a.z;
    let size = normal.x.abs() * a.x.abs() + normal.y.abs() * a.y.abs() + normal.z.abs() * a.z.abs();
    height > size * BACK_SLACK
}
