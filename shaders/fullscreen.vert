#version 460
// One triangle over the whole picture; or four of them, at the depths of the classes of pixels that have bit BIT as VALUE says.
#include "classes.glsl"

layout(constant_id = 10) const int BIT = -1;
layout(constant_id = 11) const int VALUE = 0;

layout(location = 0) out vec2 out_uv;

void main() {
    out_uv = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    float depth = BIT < 0 ? 0.0 : class_depth(class_with(BIT, VALUE, gl_InstanceIndex));
    gl_Position = vec4(out_uv * 2.0 - 1.0, depth, 1.0);
}
