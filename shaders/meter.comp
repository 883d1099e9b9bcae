#version 460
// Histogram of the picture's luminance, by its logarithm: every METER_STRIDE-th pixel of both directions is counted.
#extension GL_EXT_scalar_block_layout : require
#include "metering.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2D radiance;
layout(scalar, binding = 2) buffer Histogram { uint bins[]; };

shared uint counts[METER_BINS];

void main() {
    for (uint k = gl_LocalInvocationIndex; k < METER_BINS; k += 256u) counts[k] = 0u;
    barrier();
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy) * int(METER_STRIDE);
    if (all(lessThan(texel, textureSize(radiance, 0)))) {
        atomicAdd(counts[bin_of(dot(texelFetch(radiance, texel, 0).rgb, LUMINANCE))], 1u);
    }
    barrier();
    for (uint k = gl_LocalInvocationIndex; k < METER_BINS; k += 256u) {
        if (counts[k] > 0u) atomicAdd(bins[k], counts[k]);
    }
}
