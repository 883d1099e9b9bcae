#version 460
// Table: light that arrives at a height by more than one scattering, as if from all sides alike: an endless sum of orders from the
// first two (Hillaire 2020, section 5.5). By the sun's elevation and height.
#include "sunlight.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2D table;

// Light that comes from a direction after one scattering of sunlight to all sides alike, or from the ground, over the sun's irradiance;
// and what would come if the air shone with a radiance of 1.
void look(float height, vec3 ray, vec3 sun, out vec3 second, out vec3 share) {
    second = share = vec3(0.0);
    bool to_ground = ray.z < horizon_cosine(level_at(height));
    float whole = way_length(height, ray.z, to_ground), r = bottom_radius() + height, nu = dot(ray, sun);
    vec3 passed = vec3(1.0);
    for (int k = 0; k < MULTIPLE_STEPS; ++k) {
        // Finest where the ray begins; both ends are in dense air where it meets the ground.
        float a = float(k) / float(MULTIPLE_STEPS), b = float(k + 1) / float(MULTIPLE_STEPS);
        float from = to_ground ? unspread(a) : a * a, to = to_ground ? unspread(b) : b * b;
        float t = 0.5 * (from + to) * whole;
        vec2 reached = after(height, ray.z, t);
        Medium medium = medium_at(reached.x);
        vec3 here = exp(-medium.extinction * (to - from) * whole);
        vec3 weight = passed * (1.0 - here) * (medium.rayleigh + medium.mie) / max(medium.extinction, vec3(1e-20));
        second += weight * sun_share(level_at(reached.x), (r * sun.z + t * nu) / reached.y) / (4.0 * PI);
        share += weight;
        passed *= here;
    }
    if (to_ground) {
        float c = (r * sun.z + whole * nu) / bottom_radius();
        second += passed * shading.ground_albedo / PI * sun_share(level_at(0.0), c) * max(c, 0.0);
    }
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(table);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = sun_height(from_texel(texel, size));
    vec3 sun = vec3(sqrt(max(1.0 - at.y * at.y, 0.0)), 0.0, at.y);
    vec3 second = vec3(0.0), share = vec3(0.0);
    for (int k = 0; k < MULTIPLE_ROUND * MULTIPLE_LAYERS; ++k) {
        float z = 2.0 * (float(k / MULTIPLE_ROUND) + 0.5) / float(MULTIPLE_LAYERS) - 1.0, azimuth = PI * (float(k % MULTIPLE_ROUND) + 0.5) / float(MULTIPLE_ROUND);
        vec3 one_second, one_share;
        look(at.x, vec3(sqrt(1.0 - z * z) * vec2(cos(azimuth), sin(azimuth)), z), sun, one_second, one_share);
        second += one_second;
        share += one_share;
    }
    const float RAYS = float(MULTIPLE_ROUND * MULTIPLE_LAYERS);
    imageStore(table, texel, vec4(second / RAYS / max(1.0 - share / RAYS, vec3(1e-3)), 1.0));
}
