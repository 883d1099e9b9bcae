#version 460
// Pulls the vertex that an emitted index names. Neighbouring patches hold the same integers for a shared vertex, its parent and its
// wake, so they compute the same bits and no crack can open.
#include "frame.glsl"
#include "shading.glsl"

// Factor on depth, above 1 for lines: they are drawn over the surface they lie on, and lines and triangles round differently.
layout(constant_id = 0) const float DEPTH_LIFT = 1.0;

layout(scalar, binding = 4) uniform View { FrameView view; };
layout(scalar, binding = 1) readonly buffer Patches { PatchDraw patches[]; };
layout(scalar, binding = 5) readonly buffer DrawnPositions { DrawnVertex drawn_positions[]; };
layout(scalar, binding = 8) readonly buffer Resolved { uint resolved[]; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec2 out_grid;
// Of the patch's table: software renderers fetch from buffers pixel by pixel, and flat inputs once a triangle.
// Slot, parent's slot, which quarter of that one, level (low half) and the first vertex's wake (high half); corner in the texture, cell, where it fades; grid axis, texel's distance.
layout(location = 2) flat out uvec4 out_slots;
layout(location = 3) flat out vec4 out_texture;
layout(location = 4) flat out vec4 out_axis;
// Distances in metres from nearer than which the grid of each quarter deviates by more than it may; and, in mode error, what sleeps here.
layout(location = 5) flat out vec4 out_deviations;
layout(location = 6) out float out_asleep;

invariant gl_Position;

vec2 grid_position(Vertices vertices, uint v) {
    uint grid = grid_of(vertices, v);
    uint row = view.cells + 1u;
    return vec2(grid % row, grid / row);
}

// How near a collapse that v stands for can be seen, in lattice units: its wake, less the longest edge that is surely within that.
float error_distance(Vertices vertices, PatchDraw target, uint v) {
    uint code = wake_code(vertices.at[v], target.coarser_sides, view.cells);
    vec3 edge = vec3(vertices.at[v].position - vertices.at[parent_of(vertices, v)].position);
    return code == WAKE_ALWAYS || code == WAKE_ASLEEP ? 0.0 : max(wake_distance(code) - length(edge), 0.0);
}

// The largest of those of the vertices that sleep and are drawn as v, and of v itself while it slides. Of vertices behind the prefix it is
// only known that none has a larger wake than the prefix's last.
float largest_error_distance(Vertices vertices, PatchDraw target, uint v, float weight) {
    float largest = weight > 0.0 ? error_distance(vertices, target, v) : 0.0;
    PatchVertex last = vertices.at[target.vertex_count - 1u];
    if (target.vertex_count < (view.cells + 1u) * (view.cells + 1u)) {
        largest = max(largest, wake_distance(max(high16(last.grid_wake), high16(last.parent_coarser_wake))));
    }
    for (uint k = v + 1u; k < target.vertex_count; ++k) {
        if (resolved[target.resolve_offset + k] == v) largest = max(largest, error_distance(vertices, target, k));
    }
    return largest;
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
    out_deviations = view.scale * patches[number].deviations;
    out_asleep = 0.0;
    if (mode_is(MODE_ERROR)) {
        float asleep = view.scale * view.unit * largest_error_distance(vertices, patches[number], v, drawn.weight);
        // The certificate says no more of it than that it keeps to its share of the tolerance.
        out_asleep = min(asleep, length(position));
    }
    gl_Position = vec4(clip.xy, clip.z * DEPTH_LIFT, clip.w);
}
