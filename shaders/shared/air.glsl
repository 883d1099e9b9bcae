// What the air is made of, ways through it, and how its look-up tables are laid out (Hillaire 2020; transmittance after Bruneton and
// Neyret 2008). Heights here count from the lowest ground that air lies on, and `c` is a cosine against the vertical. Differences of
// squares would lose the metres that matter near the ground: no formula here has one.

#ifndef TERRANE_AIR
#define TERRANE_AIR
#include "shading.glsl"

// Per metre.
struct Medium {
    vec3 rayleigh;
    vec3 mie;
    vec3 extinction;
};

// Densities of molecules, haze and ozone, over those at the datum.
vec3 densities_at(float height) {
    float h = height + shading.air_bottom;
    float ozone = max(1.0 - abs(h - shading.ozone_height) / shading.ozone_reach, 0.0);
    return vec3(exp(-h / shading.scale_height), exp(-h / shading.mie_scale_height), ozone);
}

Medium medium_of(vec3 densities) {
    vec3 rayleigh = shading.rayleigh * densities.x;
    vec3 extinction = rayleigh + shading.mie_extinction * densities.y + shading.ozone * densities.z;
    return Medium(rayleigh, shading.mie * densities.y, extinction);
}

Medium medium_at(float height) { return medium_of(densities_at(height)); }

float bottom_radius() { return shading.radius + shading.air_bottom; }
float thickness() { return shading.air_top - shading.air_bottom; }

// The eye's height, or the air's upper edge where it is above.
float eye_height() { return clamp(shading.height_m - shading.air_bottom, 0.0, thickness()); }
bool is_outside() { return decided_late(shading.height_m > shading.air_top); }

// Whether a view ray meets any air.
bool meets_air(vec3 ray) {
    if (!has_air() || !is_outside()) return has_air();
    vec2 hits = through_shell(ray, shading.air_top);
    return hits.x < hits.y && hits.y > 0.0;
}

float rayleigh_phase(float c) { return 3.0 / (16.0 * PI) * (1.0 + c * c); }

// Cornette and Shanks 1992.
float mie_phase(float c) {
    float g = shading.mie_g;
    float base = max(1.0 + g * g - 2.0 * g * c, 1e-4);
    return 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + c * c) / (base * sqrt(base));
}

// A height, and how far the lowest ground's horizon is from there.
struct Level {
    float height;
    float to_horizon;
};

// Cosine of that horizon against the vertical.
float horizon_cosine(Level level) { return -level.to_horizon / (bottom_radius() + level.height); }

Level level_at(float height) { return Level(height, sqrt(height * (2.0 * bottom_radius() + height))); }

// Length of a ray from a height to the lowest ground, or to the air's upper edge.
float way_length(float height, float c, bool to_ground) {
    float bottom = bottom_radius();
    float b = (bottom + height) * c;
    if (to_ground) {
        float q = height * (2.0 * bottom + height);
        return q / max(sqrt(max(b * b - q, 0.0)) - b, 1e-3);
    }
    float top = thickness();
    float q = max((top - height) * (2.0 * bottom + top + height), 0.0);
    float root = sqrt(b * b + q);
    return b > 0.0 ? q / (b + root) : root - b;
}

// Height and distance from the centre after `t` metres along a ray.
vec2 after(float height, float c, float t) {
    float r = bottom_radius() + height;
    float root = sqrt(r * r + 2.0 * r * t * c + t * t);
    return vec2(max(height + t * (2.0 * r * c + t) / (root + r), 0.0), root);
}

// Ends of a table are at the centres of its outermost texels.
vec2 to_texels(vec2 x, ivec2 size) { return (0.5 + clamp(x, 0.0, 1.0) * vec2(size - 1)) / vec2(size); }
vec2 from_texel(ivec2 texel, ivec2 size) { return vec2(texel) / vec2(size - 1); }

// --- Transmittance to the air's upper edge, by height and cosine. ---

vec2 transmittance_coordinates(Level level, float c) {
    float bottom = bottom_radius(), top = thickness(), edge = sqrt(top * (2.0 * bottom + top));
    float nearest = top - level.height, farthest = level.to_horizon + edge;
    return vec2((way_length(level.height, c, false) - nearest) / (farthest - nearest), level.to_horizon / edge);
}

// The inverse: height and cosine.
vec2 transmittance_ray(vec2 coordinates) {
    float bottom = bottom_radius(), top = thickness();
    float edge = sqrt(top * (2.0 * bottom + top)), rho = edge * coordinates.y;
    float r = sqrt(rho * rho + bottom * bottom), height = rho * rho / (r + bottom);
    float nearest = top - height, d = nearest + coordinates.x * (rho + edge - nearest);
    float c = d > 0.0 ? ((top - height) * (2.0 * bottom + top + height) - d * d) / (2.0 * r * d) : 1.0;
    return vec2(height, clamp(c, -1.0, 1.0));
}

// Share of the sun's disc above the horizon of a level.
float sun_visibility(Level level, float c) {
    return smoothstep(-SUN_RADIUS, SUN_RADIUS, c - horizon_cosine(level));
}

// --- Tables by the sun's cosine and by height, both finest near 0. ---

vec2 sun_coordinates(float height, float c) {
    return vec2(0.5 + 0.5 * sign(c) * sqrt(abs(c)), sqrt(height / thickness()));
}

// The inverse: height and cosine.
vec2 sun_height(vec2 coordinates) {
    float x = 2.0 * coordinates.x - 1.0;
    return vec2(coordinates.y * coordinates.y * thickness(), x * abs(x));
}

// --- Tables of the eye: rays by their latitude against the horizon of where they begin, where the eye is or, from outside, where they
// enter the air; the lower half of the rows meets the ground, the upper half does not, and both are finest at the horizon. ---

// Rows of the upper half, less one, of latitudes below the horizontal, where rays dip into denser air: the more of them the farther the
// horizon lies below, and all from outside. A whole number, so that the map has its bend at the centre of a row.
float dipping_rows(float horizon, float half_rows) {
    if (is_outside()) return half_rows - 1.0;
    return round((half_rows - 1.0) * horizon / (horizon - 0.035));
}

float latitude_row(float c, bool to_ground, int rows) {
    float horizon = shading.horizon, latitude = asin(clamp(c, -1.0, 1.0));
    float half_rows = float(rows / 2), dipping = dipping_rows(horizon, half_rows);
    float row;
    if (to_ground) {
        row = (half_rows - 1.0) * sqrt(clamp((horizon - latitude) / (horizon + 0.5 * PI), 0.0, 1.0));
    } else if (latitude < 0.0) {
        row = half_rows + dipping * sqrt(clamp(1.0 - latitude / horizon, 0.0, 1.0));
    } else {
        row = half_rows + dipping + (half_rows - 1.0 - dipping) * sqrt(latitude / (0.5 * PI));
    }
    return (0.5 + row) / float(rows);
}

// The inverse, for the centre of a row.
float row_cosine(int row, int rows, out bool to_ground) {
    float horizon = shading.horizon;
    float half_rows = float(rows / 2), above = float(row) - half_rows, dipping = dipping_rows(horizon, half_rows);
    to_ground = above < 0.0;
    float share = float(row) / (half_rows - 1.0);
    if (to_ground) return sin(mix(horizon, -0.5 * PI, share * share));
    share = above / max(dipping, 1.0);
    if (above < max(dipping, 1.0)) return sin(horizon * (1.0 - share * share));
    share = (above - dipping) / max(half_rows - 1.0 - dipping, 1.0);
    return sin(0.5 * PI * share * share);
}

// Distances along a ray as shares of its length, finest at both ends.
float spread(float share) { return share < 0.5 ? sqrt(0.5 * share) : 1.0 - sqrt(0.5 * (1.0 - share)); }
float unspread(float x) { return x < 0.5 ? 2.0 * x * x : 1.0 - 2.0 * (1.0 - x) * (1.0 - x); }

// Where along a ray scattered light is kept: by distance and by opacity in equal parts. By opacity alone it would be best for rays in
// daylight, but the light at the end of a long ray through the Earth's shadow would fall between the last two slices.
float ray_part(float share, float opacity_share) { return 0.5 * (spread(share) + opacity_share); }

#endif
