// What selection, emission and drawing share: patch data by address, and where vertices are drawn relative to the camera.

#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

#include "layout.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vertices { PatchVertex at[]; };
// A triangle is three 16-bit places in the wake order: x holds two, y the third.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Triangles { uvec2 at[]; };

// Camera-relative position in lattice units: integers first, so that it is exact near the camera.
vec3 relative_to_camera(ivec3 position, ivec3 anchor, vec3 offset) {
    precise vec3 result = vec3(position - anchor) - offset;
    return result;
}

uint parent_of(Vertices vertices, uint v) { return vertices.at[v].parent_coarser & 0xffffu; }

// Camera-relative place at which a vertex is drawn: on the straight way from its own place (weight 0) to its parent's (1).
// Twin: planet/src/reference/place.rs.
vec3 drawn_place(Vertices vertices, uint v, float weight, ivec3 anchor, vec3 offset) {
    vec3 own = relative_to_camera(vertices.at[v].position, anchor, offset);
    if (weight == 0.0) return own;
    vec3 parent = relative_to_camera(vertices.at[parent_of(vertices, v)].position, anchor, offset);
    precise vec3 place = own + (parent - own) * weight;
    return place;
}
