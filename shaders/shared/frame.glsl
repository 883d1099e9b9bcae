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

bool on_coarser_side(uint grid, uint sides, uint cells) {
    uint row = cells + 1u;
    uint i = grid % row;
    uint j = grid / row;
    return ((sides & SIDE_LEFT) != 0u && i == 0u) || ((sides & SIDE_RIGHT) != 0u && i == cells)
        || ((sides & SIDE_BOTTOM) != 0u && j == 0u) || ((sides & SIDE_TOP) != 0u && j == cells);
}

// The wake that counts: that beside a coarser neighbour, or the usual one.
uint wake_code(PatchVertex vertex, uint sides, uint cells) {
    bool coarser = sides != 0u && on_coarser_side(low16(vertex.grid_wake), sides, cells);
    return high16(coarser ? vertex.parent_coarser_wake : vertex.grid_wake);
}
