#version 460
// Triangles of the user interface over the picture. Corners and their indices are pulled, so that one buffer of each serves all meshes.
#extension GL_EXT_scalar_block_layout : require
#include "layout.glsl"

layout(scalar, binding = 0) readonly buffer Corners { GuiCorner corners[]; };
layout(std430, binding = 1) readonly buffer Indices { uint indices[]; };

layout(push_constant) uniform Push {
    // Clip space for one point of the interface.
    vec2 scale;
    // Where this mesh begins in each buffer.
    uint first_index;
    uint first_corner;
};

layout(location = 0) out vec2 out_texel;
layout(location = 1) out vec4 out_color;

void main() {
    GuiCorner corner = corners[first_corner + indices[first_index + gl_VertexIndex]];
    out_texel = corner.texel;
    out_color = unpackUnorm4x8(corner.color);
    gl_Position = vec4(corner.position * scale - 1.0, 0.0, 1.0);
}
