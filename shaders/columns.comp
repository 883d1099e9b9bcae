#version 460
// Tables of the eye, a row of latitude an invocation: optical depths along the row's ray, and the points that divide it into even
// parts of distance and opacity, at which the light that it scatters is sampled.
#include "air.glsl"

layout(local_size_x = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2D columns;
// Of each node: light that passes the way to it; the way's length, the distance from the planet's centre, and the level; the densities.
layout(rgba32f, binding = 2) uniform writeonly image2D nodes;
layout(rgba32f, binding = 3) uniform writeonly image2D levels;
layout(rgba32f, binding = 4) uniform writeonly image2D densities;

// Steps to a texel.
const int STEPS = 4;

vec3 depth_of(float height, float c, float from, float to) {
    return medium_at(after(height, c, 0.5 * (from + to)).x).extinction * (to - from);
}

float mean(vec3 x) { return dot(x, vec3(1.0 / 3.0)); }

// All that the lights of a row's node share. `way` is the length of the row's ray.
void store_node(ivec2 texel, float height, float c, float way, float share, vec3 passed) {
    vec2 reached = after(height, c, share * way);
    Level level = level_at(reached.x);
    imageStore(nodes, texel, vec4(passed, 0.0));
    imageStore(levels, texel, vec4(share * way, reached.y, level.height, level.to_horizon));
    imageStore(densities, texel, vec4(densities_at(level.height), 0.0));
}

void main() {
    ivec2 size = imageSize(columns);
    int row = int(gl_GlobalInvocationID.x), last_node = imageSize(nodes).x - 1;
    if (row >= size.y) return;
    bool to_ground;
    float c = row_cosine(row, size.y, to_ground), height = eye_height(), whole = max(way_length(height, c, to_ground), 1e-3);
    int count = (size.x - 1) * STEPS;

    vec3 depth = vec3(0.0);
    for (int k = 0; k < count; ++k) {
        depth += depth_of(height, c, unspread(float(k) / float(count)) * whole, unspread(float(k + 1) / float(count)) * whole);
    }
    vec3 all = depth;
    float opacity = mean(1.0 - exp(-all));
    imageStore(columns, ivec2(0, row), vec4(medium_at(height).extinction * whole, opacity));
    store_node(ivec2(0, row), height, c, whole, 0.0, vec3(1.0));

    depth = vec3(0.0);
    int node = 1;
    float reached = 0.0;
    for (int k = 0; k < count; ++k) {
        float from = unspread(float(k) / float(count)), to = unspread(float(k + 1) / float(count));
        vec3 further = depth + depth_of(height, c, from * whole, to * whole);
        float next = ray_part(to, mean(1.0 - exp(-further)) / max(opacity, 1e-9));
        while (node < last_node && next > float(node) / float(last_node)) {
            float between = clamp((float(node) / float(last_node) - reached) / (next - reached), 0.0, 1.0);
            store_node(ivec2(node, row), height, c, whole, mix(from, to, between), exp(-mix(depth, further, between)));
            ++node;
        }
        depth = further;
        reached = next;
        if ((k + 1) % STEPS == 0) imageStore(columns, ivec2((k + 1) / STEPS, row), vec4(depth / to, opacity));
    }
    for (; node <= last_node; ++node) store_node(ivec2(node, row), height, c, whole, 1.0, exp(-all));
}
