#version 460
// Pulls its vertices from a storage buffer.
#extension GL_EXT_scalar_block_layout : require

layout(binding = 0, scalar) readonly buffer Vertices { vec4 positions[]; } vertices;

layout(location = 0) out vec2 texture_coordinate;

void main() {
    vec4 position = vertices.positions[gl_VertexIndex];
    gl_Position = position;
    texture_coordinate = position.xy * 0.5 + 0.5;
}
