#version 460
// A further factor on exposure, from the histogram of luminance: the mean of the brighter half of what is not black, without the brightest
// fiftieth, which is sun and glints.
#include "shading.glsl"
#include "metering.glsl"

layout(local_size_x = 1) in;
layout(scalar, binding = 1) readonly buffer Histogram { uint bins[]; };
layout(scalar, binding = 2) buffer Exposure { float factor; };

// Luminance after exposure that needs no correction: that of a landscape in daylight.
const float USUAL = 0.2;
// Share of stops that is made up for: less than all, so that nights stay darker than days.
const float CORRECTION = 0.6;
const vec2 LIMITS = vec2(0.2, 16.0);
const vec2 PERCENTILES = vec2(0.5, 0.98);

void main() {
    float all = 0.0, seen = 0.0, sum = 0.0, weight = 0.0;
    for (uint k = 1u; k < METER_BINS; ++k) all += float(bins[k]);
    for (uint k = 1u; k < METER_BINS; ++k) {
        float count = float(bins[k]);
        float inside = max(min(seen + count, PERCENTILES.y * all) - max(seen, PERCENTILES.x * all), 0.0);
        sum += inside * float(k);
        weight += inside;
        seen += count;
    }
    float usual = USUAL / max(shading.exposure, 1e-6);
    float goal = weight > 0.0 ? clamp(pow(usual / luminance_of(sum / weight), CORRECTION), LIMITS.x, LIMITS.y) : 1.0;
    // Eyes adapt by ratios.
    factor = shading.adaptation >= 1.0 ? goal : factor * pow(goal / factor, shading.adaptation);
}
