// What selection, emission and drawing share: patch data by address, and the camera-relative position.

#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

#include "layout.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vertices { PatchVertex at[]; };
// Triangles are three 16-bit places in the wake order each, without padding: two of them in three words.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Triangles { uint at[]; };

// Camera-relative position in lattice units: integers first, so that it is exact near the camera.
vec3 relative_to_camera(ivec3 position, ivec3 anchor, vec3 offset) {
    precise vec3 result = vec3(position - anchor) - offset;
    return result;
}
