// How exposure is metered: bins of luminance, a quarter of a stop each.
#include "layout.glsl"

// Logarithm of the luminance of the first bin, which holds everything darker too: space, and what is as good as black.
const float DARKEST = -14.0;
const float BINS_PER_STOP = 4.0;

uint bin_of(float luminance) {
    return uint(clamp((log2(max(luminance, 1e-9)) - DARKEST) * BINS_PER_STOP, 0.0, float(METER_BINS - 1u)));
}

float luminance_of(float bin) { return exp2(DARKEST + (bin + 0.5) / BINS_PER_STOP); }
