#version 460
// Table: irradiance of the whole sky on level ground, by the sun's elevation and height.
#include "scattering.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2D table;

const int ROUND = 8;
const int LAYERS = 8;
const int STEPS = 24;

vec3 sky(float height, vec3 ray, vec3 sun) {
    vec3 sum = vec3(0.0), passed = vec3(1.0);
    float whole = way_length(height, ray.z, false), r = bottom_radius() + height, nu = dot(ray, sun);
    float phase = rayleigh_phase(nu), haze_phase = mie_phase(nu);
    for (int k = 0; k < STEPS; ++k) {
        float from = float(k * k) / float(STEPS * STEPS), to = float((k + 1) * (k + 1)) / float(STEPS * STEPS);
        float t = 0.5 * (from + to) * whole;
        vec2 reached = after(height, ray.z, t);
        Medium medium = medium_at(reached.x);
        Source source = source_at(medium, level_at(reached.x), (r * sun.z + t * nu) / reached.y, phase);
        vec3 here = exp(-medium.extinction * (to - from) * whole);
        sum += passed * (1.0 - here) * (source.molecules + haze_phase * source.haze) / max(medium.extinction, vec3(1e-20));
        passed *= here;
    }
    return sum;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(table);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = sun_height(from_texel(texel, size));
    vec3 sun = vec3(sqrt(max(1.0 - at.y * at.y, 0.0)), 0.0, at.y);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < ROUND * LAYERS; ++k) {
        // Equal shares of a hemisphere weighted by the cosine: squares of sines spread evenly.
        float z = sqrt((float(k / ROUND) + 0.5) / float(LAYERS)), azimuth = PI * (float(k % ROUND) + 0.5) / float(ROUND);
        sum += sky(at.x, vec3(sqrt(1.0 - z * z) * vec2(cos(azimuth), sin(azimuth)), z), sun);
    }
    imageStore(table, texel, vec4(SUN * PI * sum / float(ROUND * LAYERS), 1.0));
}
