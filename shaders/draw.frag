#version 460
// Ground: normals and albedo from per-patch textures, never from the triangles, lit by the sun and the sky.
#include "frame.glsl"
#include "skylight.glsl"
#include "clouds.glsl"

layout(binding = 2) uniform sampler2DArray slopes;
layout(binding = 3) uniform sampler2DArray albedo;
layout(binding = 6) uniform sampler2DArray relief;
layout(binding = 7) uniform sampler2DArray grain_map;

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_grid;
// See draw.vert.
layout(location = 2) flat in uvec4 in_slots;
layout(location = 3) flat in vec4 in_texture;
layout(location = 4) flat in vec4 in_axis;
layout(location = 5) flat in vec4 in_deviations;
layout(location = 6) in float in_asleep;
layout(location = 0) out vec4 out_color;

layout(scalar, binding = 4) uniform View { FrameView view; };

// Radians, a little more than half the sun's disc: the relief is known to a texel only.
const float PENUMBRA = 0.008;

// Mean slope of the crowns of trees, and how much their brightness varies.
const float CROWN_SLOPE = 0.7;
const float CROWN_SHADE = 0.42;

struct Ground {
    vec2 slope;
    vec3 albedo;
    float shore;
    // Sine of the horizon's elevation towards the sun, and the share of the sky's light.
    vec2 relief;
};

// Where image layers of `layer_side` texels a side hold texel `at` (0 to `side`) of a slot's tile. Nothing is rounded but the texel, to a
// 1024th, and a layer's side is a power of two: so a patch looks the same to the last bit whichever slot it got.
vec3 in_layer(uint slot, vec2 at, float side, int layer_side) {
    uint tile = slot % (TILES_PER_SIDE * TILES_PER_SIDE);
    vec2 corner = side * vec2(tile % TILES_PER_SIDE, tile / TILES_PER_SIDE);
    precise vec2 place = (corner + floor(1024.0 * at) / 1024.0) / float(layer_side);
    return vec3(place, float(slot / (TILES_PER_SIDE * TILES_PER_SIDE)));
}

// Samples lie a little outside of the patch where a pixel's centre does: never so far that a neighbouring tile shows, at any mip level.
Ground fetch(uint slot, vec2 grid, float lod) {
    float cells = float(view.cells);
    vec2 texel = 2.0 * clamp(grid, vec2(-1.0), vec2(cells + 1.0)) + float(TEXTURE_GUTTER);
    vec3 at = in_layer(slot, texel, 2.0 * (cells + float(TEXTURE_GUTTER)), textureSize(albedo, 0).x);
    vec4 color = textureLod(albedo, at, lod);
    vec3 vertex = in_layer(slot, clamp(grid, vec2(0.0), vec2(cells)) + 0.5, cells + 1.0, textureSize(relief, 0).x);
    return Ground(textureLod(slopes, at, lod).xy, color.rgb, color.a, textureLod(relief, vertex, 0.0).xy);
}

// Textures are those of the patch or of an ancestor, whichever is fine enough. They fade in over those of the next coarser patch by
// distance, so that no switch of detail is seen. The mip level comes from distance and slant, not from screen derivatives: those differ
// between the triangles of one surface, and show its edges.
Ground ground_of(float distance, float slant) {
    float lod = log2(distance / in_axis.w) - 0.5 * log2(max(slant, 0.02));
    vec2 at = in_texture.xy + in_texture.z * in_grid;
    Ground own = fetch(in_slots.x, at, lod);
    float parent_share = smoothstep(FADE_FROM, 1.0, distance / in_texture.w);
    // A loop of one turn or none: see counted_axes.
    for (int turns = int(in_slots.y != NO_SLOT && parent_share > 0.0); turns > 0; --turns) {
        vec2 grid = 0.5 * (at + float(view.cells) * vec2(in_slots.z & 1u, in_slots.z >> 1));
        Ground parent = fetch(in_slots.y, grid, lod - 1.0);
        own.slope = mix(own.slope, parent.slope, parent_share);
        own.albedo = mix(own.albedo, parent.albedo, parent_share);
        own.shore = mix(own.shore, parent.shore, parent_share);
        own.relief = mix(own.relief, parent.relief, parent_share);
    }
    return own;
}

// Copies of each layer of the grain within REPEAT_M. Ground: 5 m and 0.8 m wide, finer than what the finest patches hold. Crowns: 256 m and 146 m wide,
// for trees of 8 and 4.6 m; in woods they stand in for the coarser copy of the ground.
const float GROUND_COPIES[2] = float[](211.0, 1361.0);
const float CROWN_COPIES[2] = float[](4.0, 7.0);

// Adds a copy of a layer: slopes as a gradient in space, and brightness; both fade into nothing where a pixel holds many of them.
void add_grain(inout vec4 sum, vec3 position, vec3 weights, float texels, float copies, float layer, float share) {
    float lod = log2(texels * copies);
    // Single crowns are gone by then: what is left of them would only show where the map repeats.
    if (layer == CROWN_LAYER) share *= smoothstep(4.5, 2.5, lod);
    for (uint axes = lod > 7.0 || share <= 0.0 ? 0u : counted_axes(weights); axes != 0u;) {
        int axis = next_axis(axes);
        vec3 found = textureLod(grain_map, vec3(coordinates_along(axis, position) * copies, layer), lod).xyz;
        sum += share * weights[axis] * vec4(gradient_along(axis, found.xy), found.z);
    }
}

// Grain of bare ground, and of what is wooded.
void grain_of(vec3 from_camera, vec3 up, float footprint, float wooded, out vec4 bare, out vec4 crowns) {
    bare = vec4(0.0);
    crowns = vec4(0.0);
    float texels = footprint * float(textureSize(grain_map, 0).x) / REPEAT_M;
    if (log2(texels * CROWN_COPIES[0]) > 4.5) return;
    vec3 position = in_periods(from_camera), weights = axis_weights(up);
    add_grain(crowns, position, weights, texels, CROWN_COPIES[0], CROWN_LAYER, 0.8 * wooded);
    add_grain(crowns, position + 0.37, weights, texels, CROWN_COPIES[1], CROWN_LAYER, 0.6 * wooded);
    add_grain(bare, position, weights, texels, GROUND_COPIES[0], GROUND_LAYER, 1.0 - wooded);
    add_grain(bare, position, weights, texels, GROUND_COPIES[1], GROUND_LAYER, 1.0);
}

// How much of the ground is under trees: what is dark and green.
float wooded_share(vec3 albedo) {
    float green = smoothstep(1.2, 1.45, albedo.g / max(albedo.r, 1e-3));
    return green * smoothstep(0.085, 0.055, dot(albedo, vec3(0.3, 0.6, 0.1)));
}

// How long a vertex has been awake: yellow where it has just woken, red at twice that nearness, and through violet to blue at thirty times.
vec3 wake_color(float wake, float distance) {
    float octaves = log2(max(view.scale * wake * view.unit / distance, 1.0));
    vec3 warm = mix(vec3(1.0, 0.85, 0.1), vec3(0.85, 0.15, 0.15), min(octaves, 1.0));
    return mix(warm, vec3(0.1, 0.15, 0.6), smoothstep(1.0, 5.0, octaves));
}

// The share of the tolerance that the certified error takes: blue for none, green for half, yellow for all of it; red beyond, at twice as much.
vec3 error_color(float share) {
    vec3 within = mix(vec3(0.1, 0.15, 0.6), vec3(0.15, 0.65, 0.3), min(2.0 * share, 1.0));
    within = mix(within, vec3(1.0, 0.85, 0.1), clamp(2.0 * share - 1.0, 0.0, 1.0));
    return mix(within, vec3(0.9, 0.05, 0.1), clamp(share - 1.0, 0.0, 1.0));
}

vec3 level_color(uint level) {
    vec3 phase = vec3(0.0, 0.33, 0.67) + 0.382 * float(level);
    return 0.55 + 0.45 * cos(6.2832 * phase);
}

void main() {
    float distance = length(in_position);
    vec3 from_centre = shading.camera + in_position;
    vec3 up = normalize(from_centre);
    Ground ground = ground_of(distance, abs(dot(in_position, up)) / distance);
    vec3 along = normalize(in_axis.xyz - up * dot(in_axis.xyz, up));
    vec3 normal = normalize(up - along * ground.slope.x - cross(up, along) * ground.slope.y);
    float footprint = distance * pixel_angle() * inversesqrt(max(abs(dot(in_position, normal)) / distance, 0.05));
    float wooded = wooded_share(ground.albedo);
    vec4 bare, crowns;
    grain_of(in_position, up, footprint, wooded, bare, crowns);
    // Snow and sand are smoother than what grows or lies about.
    float roughness = mix(0.26, 0.08, smoothstep(0.2, 0.6, dot(ground.albedo, vec3(0.3, 0.6, 0.1))));
    vec3 gradient = roughness * bare.xyz + CROWN_SLOPE * crowns.xyz;
    normal = normalize(normal - (gradient - normal * dot(gradient, normal)));
    ground.albedo *= max(1.0 + 0.8 * roughness * bare.w + CROWN_SHADE * crowns.w, 0.15);

    if (mode_is(MODE_NORMALS)) {
        out_color = vec4(0.5 + 0.5 * normal, 1.0);
        return;
    }
    if (mode_is(MODE_ALBEDO)) {
        out_color = vec4(ground.albedo, 1.0);
        return;
    }
    if (mode_is(MODE_DEPTH)) {
        // 1 m to 100,000 km, near is bright.
        out_color = vec4(vec3(clamp(1.0 - log2(max(distance, 1.0)) / 26.6, 0.0, 1.0)), 1.0);
        return;
    }
    vec3 color = ground.albedo;
    if (mode_is(MODE_LEVELS)) color = mix(color, level_color(low16(in_slots.w)), 0.65);
    if (mode_is(MODE_WAKE)) color = mix(color, wake_color(wake_distance(high16(in_slots.w)), distance), 0.8);
    if (mode_is(MODE_ERROR)) {
        vec2 half_way = step(vec2(0.5 * float(view.cells)), in_grid);
        float deviation = in_deviations[int(half_way.x + 2.0 * half_way.y)];
        float share = (1.0 - DEVIATION_SHARE) * min(in_asleep / distance, 1.0) + DEVIATION_SHARE * deviation / distance;
        color = mix(color, error_color(share), 0.8);
    }

    float height = length(from_centre) - shading.radius;
    float elevation = dot(up, shading.sun);
    // The share of the sun's disc above the relief.
    float facing = max(dot(normal, shading.sun), 0.0) * smoothstep(-PENUMBRA, PENUMBRA, elevation - ground.relief.x + shading.horizon_drop);
    vec3 sun = sun_irradiance(height, elevation) * cloud_shadow(from_centre, height, elevation, footprint);
    vec3 sky = sky_irradiance(height, elevation);
    float open = (0.5 + 0.5 * dot(normal, up)) * ground.relief.y;
    // Light thrown back by the ground around, as bright as the ground here.
    vec3 bounce = color * (sun * max(elevation, 0.0) + sky);
    vec3 arriving = sun * facing + sky * open + bounce * (1.0 - open);
    // The height above the sea is for the ocean: the mesh may be coarser than the water is deep.
    out_color = vec4(color / PI * arriving, decode_shore(ground.shore));
}
