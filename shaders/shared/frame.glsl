// What selection, resolution, emission and drawing share: patch data by address.

#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

#include "codings.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vertices { PatchVertex at[]; };
// Triangles are three 16-bit vertex indices each, without padding: two of them in three words.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Triangles { uint at[]; };

uint grid_of(Vertices vertices, uint v) { return low16(vertices.at[v].grid_wake); }
uint parent_of(Vertices vertices, uint v) { return low16(vertices.at[v].parent_coarser_wake); }
