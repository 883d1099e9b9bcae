#version 460
// Turns the count of emitted triangles into the indirect draw, within the index buffer's capacity.
#extension GL_EXT_scalar_block_layout : require
#include "layout.glsl"

layout(local_size_x = 1) in;

layout(scalar, binding = 0) buffer State { EmitState state; };

void main() {
    state.index_count = 3u * min(state.wanted, state.capacity);
}
