#version 460
// Table: light that passes from a height to the air's upper edge, by height and direction.
#include "air.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2D table;

// Optical depth from the ray's lowest point, at distance `lowest`, to distance `to`. Steps grow away from it as air thins out.
vec3 depth_from(float height, float c, float lowest, float to) {
    const int STEPS = 64;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < STEPS; ++k) {
        float a = float(k) / float(STEPS), b = float(k + 1) / float(STEPS), middle = 0.5 * (a + b);
        float t = lowest + (to - lowest) * middle * middle;
        sum += medium_at(after(height, c, t).x).extinction * (b * b - a * a);
    }
    return sum * abs(to - lowest);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(table);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 ray = transmittance_ray(from_texel(texel, size));
    float whole = way_length(ray.x, ray.y, false);
    float lowest = max(-ray.y * (bottom_radius() + ray.x), 0.0);
    vec3 depth = depth_from(ray.x, ray.y, lowest, whole);
    if (lowest > 0.0) depth += depth_from(ray.x, ray.y, lowest, 0.0);
    imageStore(table, texel, vec4(exp(-depth), 1.0));
}
