#version 460
// One triangle over the whole picture; or, with a BIT of classes of pixels, one at the depth of each class that has it, or of the clouds
// where they begin.
#include "classes.glsl"

layout(constant_id = 10) const int BIT = -1;

layout(location = 0) out vec2 out_uv;

void main() {
    out_uv = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    float depth = BIT < 0 ? 0.0 : BIT == CLOUDS_BIT ? CLOUDS_FROM : class_depth(class_with(BIT, gl_InstanceIndex));
    gl_Position = vec4(out_uv * 2.0 - 1.0, depth, 1.0);
}
