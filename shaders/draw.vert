#version 460
// Pulls the vertex that an emitted index names. Neighbouring patches hold the same three integers for a shared vertex, so
// they compute the same bits and no crack can open.
#include "frame.glsl"

// Factor on depth, above 1 for lines: they are drawn over the surface they lie on, and lines and triangles round differently.
layout(constant_id = 0) const float DEPTH_LIFT = 1.0;

layout(scalar, binding = 4) readonly buffer View { FrameView view; };
layout(scalar, binding = 1) readonly buffer Patches { PatchDraw patches[]; };

layout(location = 0) out vec3 out_place;
layout(location = 1) out vec2 out_grid;
layout(location = 2) flat out uint out_patch;

invariant gl_Position;

void main() {
    uint number = uint(gl_VertexIndex) >> VERTEX_BITS;
    uint v = uint(gl_VertexIndex) & ((1u << VERTEX_BITS) - 1u);
    PatchVertex vertex = Vertices(patches[number].vertices).at[v];
    uint grid = vertex.grid_own & 0xffffu;
    uint row = view.cells + 1u;
    precise vec3 place = relative_to_camera(vertex.position, view.anchor, view.offset) * view.unit;
    precise vec4 clip = view.clip * vec4(place, 1.0);
    out_place = place;
    out_grid = vec2(grid % row, grid / row);
    out_patch = number;
    gl_Position = vec4(clip.xy, clip.z * DEPTH_LIFT, clip.w);
}
