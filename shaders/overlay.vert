#version 460
// One quad for each character of the text over the picture; a character is a cell of a grid.
#include "layout.glsl"

layout(std430, binding = 0) readonly buffer Cells { uint cells[]; };

// Size of a cell in clip space.
layout(push_constant) uniform Push { vec2 cell; };

layout(location = 0) out vec2 out_pixel;
layout(location = 1) flat out uint out_code;

void main() {
    uint word = cells[gl_InstanceIndex];
    const uint MASK = (1u << TEXT_POSITION_BITS) - 1u;
    vec2 position = vec2(word & MASK, word >> TEXT_POSITION_BITS & MASK);
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1 & 1);
    // Glyphs are 8 × 8 pixels, with one row of space above and below.
    out_pixel = corner * vec2(TEXT_CELL) - vec2(0.0, 1.0);
    out_code = word >> (2u * TEXT_POSITION_BITS);
    gl_Position = vec4((position + corner) * cell - 1.0, 0.0, 1.0);
}
