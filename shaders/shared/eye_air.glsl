// The air between the eye and what it sees, from the tables of the eye: columns.comp and aerial.comp fill them.
//
// What is stored varies slowly: mean extinctions, and scattered light over opacity, which in a uniform medium is a constant. Both are
// turned back with the exact length of each pixel's ray, so that the tables can be coarse and nothing bands at the horizon.

#ifndef TERRANE_EYE_AIR
#define TERRANE_EYE_AIR
#include "air.glsl"

// Optical depth over the share of the way; alpha is the mean opacity of the whole way. By share and latitude.
layout(binding = 12) uniform sampler2D columns;
// Light over opacity, by azimuth, latitude and part of the ray: scattered by molecules or more than once, and by haze without its
// phase function.
layout(binding = 13) uniform sampler2DArray scattered_table;
layout(binding = 14) uniform sampler2DArray haze_table;

// A view ray in the air: where it begins, and its coordinates in the tables.
struct Way {
    float start;
    float whole;
    // Azimuth and latitude.
    vec2 coordinates;
};

// By the cosine: what is the same to the left and to the right is smooth in it, and it is finest across, where terminators lie.
float azimuth_column(vec3 ray, vec3 up, vec3 towards, int columns_count) {
    vec3 along = ray - up * dot(ray, up);
    float cosine = dot(along, towards) * inversesqrt(max(dot(along, along), 1e-20));
    return (0.5 + (0.5 - 0.5 * clamp(cosine, -1.0, 1.0)) * float(columns_count - 1)) / float(columns_count);
}

// False if the ray passes the air.
bool find_way(vec3 ray, out Way way) {
    vec3 up = shading.vertical;
    float height = eye_height(), c = dot(ray, up);
    way.start = 0.0;
    if (is_outside()) {
        vec2 hits = through_shell(ray, shading.air_top);
        if (hits.x >= hits.y || hits.y <= 0.0) return false;
        float aside = length(cross(shading.camera, ray)) / (bottom_radius() + height);
        way.start = hits.x;
        c = -sqrt(max((1.0 - aside) * (1.0 + aside), 0.0));
    }
    bool to_ground = c < sin(shading.horizon);
    ivec2 size = textureSize(scattered_table, 0).xy;
    way.whole = max(way_length(height, c, to_ground), 1e-3);
    way.coordinates = vec2(azimuth_column(ray, up, shading.sunward, size.x), latitude_row(c, to_ground, size.y));
    return true;
}

vec3 slice(sampler2DArray table, vec2 coordinates, float share) {
    float last = float(textureSize(table, 0).z - 1);
    float at = clamp(share, 0.0, 1.0) * last;
    float below = min(floor(at), last - 1.0);
    vec3 a = textureLod(table, vec3(coordinates, below), 0.0).rgb, b = textureLod(table, vec3(coordinates, below + 1.0), 0.0).rgb;
    return mix(a, b, at - below);
}

// Optical depth over the share of the way to a distance; alpha is the mean opacity of the whole way.
vec4 column_to(Way way, float share) {
    ivec2 size = textureSize(columns, 0);
    return textureLod(columns, vec2((0.5 + spread(share) * float(size.x - 1)) / float(size.x), way.coordinates.y), 0.0);
}

// The air before something.
struct Air {
    Way way;
    // Share of light that passes it.
    vec3 passed;
    // Light scattered towards the eye, over opacity.
    vec3 glow;
};

vec3 scattered(Air air) { return air.glow * (1.0 - air.passed); }

float way_share(Way way, float distance) { return clamp((distance - way.start) / way.whole, 0.0, 1.0); }

// The first `distance` metres of a view ray.
Air air_before(vec3 ray, float distance) {
    Air air = Air(Way(0.0, 0.0, vec2(0.0)), vec3(1.0), vec3(0.0));
    if (!has_air() || !find_way(ray, air.way)) return air;
    float share = way_share(air.way, distance);
    vec4 column = column_to(air.way, share);
    air.passed = exp(-column.rgb * share);
    float part = ray_part(share, dot(1.0 - air.passed, vec3(1.0 / 3.0)) / max(column.a, 1e-9));
    float phase = mie_phase(dot(ray, shading.sun));
    air.glow = slice(scattered_table, air.way.coordinates, part) + phase * slice(haze_table, air.way.coordinates, part);
    return air;
}

// The nearer part of the air before something: it glows about as the whole does.
Air nearer_air(Air whole, float distance) {
    if (!has_air() || whole.way.whole <= 0.0) return whole;
    float share = way_share(whole.way, distance);
    whole.passed = exp(-column_to(whole.way, share).rgb * share);
    return whole;
}

// The sky of a direction as from the eye, without the sun's disc: the whole way, for which the ends of the tables are enough.
vec3 sky_radiance(vec3 ray) {
    Way way;
    if (!has_air() || !find_way(ray, way)) return vec3(0.0);
    float last = float(textureSize(scattered_table, 0).z - 1);
    vec3 opacity = 1.0 - exp(-textureLod(columns, vec2(1.0, way.coordinates.y), 0.0).rgb);
    vec3 haze = textureLod(haze_table, vec3(way.coordinates, last), 0.0).rgb;
    return opacity * (textureLod(scattered_table, vec3(way.coordinates, last), 0.0).rgb + mie_phase(dot(ray, shading.sun)) * haze);
}

#endif
