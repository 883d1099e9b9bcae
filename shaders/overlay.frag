#version 460
// White glyphs on a dark veil, premultiplied.
layout(std430, binding = 1) readonly buffer Glyphs { uint glyphs[]; };

layout(location = 0) in vec2 in_pixel;
layout(location = 1) flat in uint in_code;
layout(location = 0) out vec4 out_color;

void main() {
    ivec2 at = ivec2(floor(in_pixel));
    bool lit = false;
    if (at.y >= 0 && at.y < 8) {
        uint rows = glyphs[2u * in_code + uint(at.y >> 2)];
        lit = (rows >> (8 * (at.y & 3) + clamp(at.x, 0, 7)) & 1u) != 0u;
    }
    out_color = lit ? vec4(0.95) : vec4(0.0, 0.0, 0.0, 0.5);
}
