#version 460
// Stars: a quad each, over the sky. See stars.comp.
#include "shading.glsl"

layout(scalar, binding = 1) readonly buffer Stars { Star stars[]; };

layout(location = 0) out vec2 out_offset;
layout(location = 1) flat out vec3 out_radiance;

// Pixels from the centre to the quad's edge.
const float REACH = 2.0;

void main() {
    Star star = stars[gl_InstanceIndex];
    out_radiance = star.radiance;
    out_offset = REACH * (vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 1.0);
    gl_Position = vec4(in_window(star.at + out_offset * vec2(2.0) / shading.size), 0.0, 1.0);
}
