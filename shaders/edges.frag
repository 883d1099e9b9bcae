#version 460
// Edges of the ground: from several samples of coverage and depth a pixel, one sample that the next stages go on with, and a note where
// others show another surface. The last stage mixes such a pixel with the neighbour that shows that surface: as smooth as multisampling,
// while sea, air and curve are computed once a pixel.
#include "edges.glsl"

layout(binding = 0) uniform sampler2DMS ground_samples;
layout(binding = 1) uniform sampler2DMS depth_samples;

layout(location = 0) out vec4 out_ground;
// See edges.glsl.
layout(location = 1) out float out_edge;

layout(constant_id = 0) const int SAMPLES = 4;

// Depths that differ by more than this factor are those of different surfaces.
const float APART = 1.06;
// Stands for the depth of the sky.
const float NOTHING = 1e-12;

float log_depth(ivec2 pixel, int k) { return log(max(texelFetch(depth_samples, pixel, k).r, NOTHING)); }

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), size = textureSize(depth_samples);
    out_ground = texelFetch(ground_samples, pixel, 0);
    gl_FragDepth = texelFetch(depth_samples, pixel, 0).r;
    out_edge = 0.0;
    float own = log_depth(pixel, 0), other = own;
    int count = 0;
    for (int k = 1; k < SAMPLES; ++k) {
        float depth = log_depth(pixel, k);
        if (abs(depth - own) > log(APART)) {
            other = depth;
            ++count;
        }
    }
    if (count == 0) return;
    float best = abs(other - own);
    int chosen = -1;
    for (int k = 0; k < 8; ++k) {
        float apart = abs(log_depth(clamp(pixel + NEIGHBOURS[k], ivec2(0), size - 1), 0) - other);
        if (apart < best) {
            best = apart;
            chosen = k;
        }
    }
    if (chosen >= 0) out_edge = float(edge_code(count * SHARE_PARTS / SAMPLES, chosen)) / 255.0;
}
