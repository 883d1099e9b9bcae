#version 460
// One triangle over the whole picture, or several at depths of classes of pixels: FIRST, and from there by LOW and HIGH, in halves.
#include "classes.glsl"

layout(constant_id = 10) const int FIRST = 0;
layout(constant_id = 11) const int LOW = 0;
layout(constant_id = 12) const int HIGH = 0;

layout(location = 0) out vec2 out_uv;

void main() {
    out_uv = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    float depth = class_depth(FIRST + LOW * (gl_InstanceIndex & 1) + HIGH * (gl_InstanceIndex >> 1));
    gl_Position = vec4(out_uv * 2.0 - 1.0, depth, 1.0);
}
