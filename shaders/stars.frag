#version 460
// A star's share of a pixel: a bell whose sum over all pixels hardly depends on where between them the star is, so that stars do not
// twinkle when the camera turns.

layout(binding = 2) uniform sampler2D depth;

layout(location = 0) in vec2 in_offset;
layout(location = 1) flat in vec3 in_radiance;
layout(location = 0) out vec4 out_color;

void main() {
    float seen = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r > 0.0 ? 0.0 : 1.0;
    const float WIDTH = 0.6;
    float bell = exp(-0.5 * dot(in_offset, in_offset) / (WIDTH * WIDTH)) / (6.2831853 * WIDTH * WIDTH);
    out_color = vec4(in_radiance * bell * seen, 0.0);
}
