#version 460
// Edges at one sample a pixel, first part: which pixels show the sky, and which the sea. An invocation looks at 32 pixels of a row.
#include "shading.glsl"
#include "edge_planes.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;
layout(scalar, binding = 3) writeonly buffer EdgeBits { uint bits[]; };

void main() {
    ivec2 image = textureSize(depth, 0), size = seen_size(image, shading.size, shading.window.xy);
    int number = own_number(), word = number % words_of(image), row = number / words_of(image);
    if (row >= size.y || word >= words_of(size)) return;
    int last = min(32, size.x - 32 * word);
    uint sky = 0u, sea = 0u;
    for (int k = 0; k < last; ++k) sky |= uint(texelFetch(depth, ivec2(32 * word + k, row), 0).r <= 0.0) << k;
    // Loops in place of conditions: software renderers run the bodies of all conditions.
    bool has_sea = decided_late(shading.sea_level > NO_SEA) && decided_late(shading.height_m > shading.sea_level) && !draws_diagram();
    for (int k = has_sea && sky != ~0u ? 0 : last; k < last; ++k) {
        sea |= uint(texelFetch(ground, ivec2(32 * word + k, row), 0).a < 0.0) << k;
    }
    sea &= ~sky;
    // Where there is no ground in the picture the sea may still be.
    vec3 ray = view_ray(vec2(32.0 * float(word) + 0.5, float(row) + 0.5) / vec2(image));
    vec3 by = shading.right * (2.0 * shading.window.z / (float(image.x) * shading.size.x));
    bool falls = min(dot(ray, shading.vertical), dot(ray + 31.0 * by, shading.vertical)) < 0.0;
    for (uint open = has_sea && falls ? sky : 0u; open != 0u; open &= open - 1u) {
        int k = findLSB(open);
        sea |= uint(distance_to_sea(normalize(ray + float(k) * by)) > 0.0) << k;
    }
    bits[word_index(size, SKY, word, row)] = sky & ~sea;
    bits[word_index(size, SEA, word, row)] = sea;
}
