#version 460
// Pulls the vertex that an emitted index names. Neighbouring patches hold the same integers for a shared vertex, its parent and its
// wake, so they compute the same bits and no crack can open.
#include "frame.glsl"

// Factor on depth, above 1 for lines: they are drawn over the surface they lie on, and lines and triangles round differently.
layout(constant_id = 0) const float DEPTH_LIFT = 1.0;

layout(scalar, binding = 4) uniform View { FrameView view; };
layout(scalar, binding = 1) readonly buffer Patches { PatchDraw patches[]; };
layout(scalar, binding = 5) readonly buffer DrawnPositions { DrawnVertex drawn_positions[]; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec2 out_grid;
// Of the patch's table: software renderers fetch from buffers pixel by pixel, and flat inputs once a triangle.
// Slot, parent's slot, which quarter of that one, level (low half) and the first vertex's wake (high half); corner in the texture, cell, where it fades; grid axis, texel's distance.
layout(location = 2) flat out uvec4 out_slots;
layout(location = 3) flat out vec4 out_texture;
layout(location = 4) flat out vec4 out_axis;

invariant gl_Position;

vec2 grid_position(Vertices vertices, uint v) {
    uint grid = grid_of(vertices, v);
    uint row = view.cells + 1u;
    return vec2(grid % row, grid / row);
}

void main() {
    uint number = uint(gl_VertexIndex) >> VERTEX_BITS;
    uint v = uint(gl_VertexIndex) & ((1u << VERTEX_BITS) - 1u);
    Vertices vertices = Vertices(patches[number].vertices);
    DrawnVertex drawn = drawn_positions[patches[number].resolve_offset + v];
    precise vec3 position = (drawn.position + view.shift) * view.unit;
    precise vec4 clip = view.clip * vec4(position, 1.0);
    out_position = position;
    out_grid = mix(grid_position(vertices, v), grid_position(vertices, parent_of(vertices, v)), drawn.weight);
    out_slots = uvec4(patches[number].slot, patches[number].parent_slot, patches[number].quarter.x | patches[number].quarter.y << 1,
        patches[number].level | high16(vertices.at[v].grid_wake) << 16);
    out_texture = vec4(patches[number].texture_corner, patches[number].texture_cell, patches[number].fade_distance);
    out_axis = vec4(patches[number].grid_axis, patches[number].texel_distance);
    gl_Position = vec4(clip.xy, clip.z * DEPTH_LIFT, clip.w);
}
