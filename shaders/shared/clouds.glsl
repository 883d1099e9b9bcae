// A sheet of cloud at one height: how deep it is over a site, and what it leaves of the sun below it. What it is made of:
// planet/src/maps/clouds.rs.

#ifndef TERRANE_CLOUDS
#define TERRANE_CLOUDS
#include "tiles.glsl"
#include "air.glsl"

layout(binding = 15) uniform sampler2D cloud_map;
layout(binding = 16) uniform sampler2D cloud_detail;

// By how much more than CLOUD_EDGE the map holds where cloud is thickest.
const float CLOUD_RISE = 0.45;
// Width of the map's texels in radii and texels a side: the root of a sphere's area.
const float CLOUD_TEXEL = 3.545;
// Widths of the tiles of detail in radii of the planet (190, 37 and 6 km on the Earth), and what they add to the map at most, about.
const vec3 DETAIL_WIDTHS = vec3(0.03, 0.0058, 0.00096);
const vec3 DETAIL_SHARES = vec3(0.035, 0.03, 0.025);
// Two and a half deviations of all of them together.
const float DETAIL_MOST = 0.14;
// Optical depth at which a sheet reflects half the light: 2 / (1 - g), for drops that scatter forwards with g = 0.8 (two-stream).
const float HALF_REFLECTED = 10.0;

bool has_clouds() { return decided_late(shading.cloud_depth > 0.0) && !draws_diagram(); }
bool is_above_clouds() { return decided_late(shading.height_m > shading.cloud_height); }

// Where a direction lies in the map, an octahedron unfolded (Cigolle et al. 2014). The outermost texels lie on its edges.
vec2 octahedral(vec3 direction) {
    vec3 d = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    vec2 folded = (1.0 - abs(d.yx)) * vec2(d.x >= 0.0 ? 1.0 : -1.0, d.y >= 0.0 ? 1.0 : -1.0);
    return to_texels(0.5 + 0.5 * (d.z >= 0.0 ? d.xy : folded), textureSize(cloud_map, 0));
}

// What the map holds around a direction, over what is the edge of clouds.
float mapped_clouds(vec3 direction, float footprint) {
    float texel = CLOUD_TEXEL * (shading.radius + shading.cloud_height) / float(textureSize(cloud_map, 0).x);
    return textureLod(cloud_map, octahedral(direction), log2(footprint / texel)).r - CLOUD_EDGE;
}

float share_of_depth(float map) {
    float share = clamp(map / CLOUD_RISE, 0.0, 1.5);
    return share * share;
}

// How much of the full depth the clouds over a direction have, 0 to 1, seldom up to 2; `footprint` is the width of what is asked about in metres;
// `coarse` is the same without detail.
float cloudiness(vec3 direction, float footprint, out float coarse) {
    float map = mapped_clouds(direction, footprint);
    coarse = share_of_depth(map);
    vec3 weights = axis_weights(direction), widths = DETAIL_WIDTHS * shading.radius;
    vec3 lods = log2(footprint * float(textureSize(cloud_detail, 0).x) / widths);
    int tiles = map < -DETAIL_MOST ? 0 : resolved_tiles(lods, 6.0);
    for (uint axes = counted_axes(weights); axes != 0u;) {
        int axis = next_axis(axes);
        for (int k = 0; k < tiles; ++k) {
            vec2 at = coordinates_along(axis, direction) / DETAIL_WIDTHS[k];
            map += weights[axis] * DETAIL_SHARES[k] * textureLod(cloud_detail, at, lods[k]).r;
        }
    }
    return share_of_depth(map);
}

// The coarse one alone.
float cloudiness_coarse(vec3 direction, float footprint) {
    return share_of_depth(mapped_clouds(direction, footprint));
}

// Where a view ray meets the sheet first; negative if it does not.
float distance_to_clouds(vec3 ray) {
    vec2 hits = through_shell(ray, shading.cloud_height);
    float t = is_above_clouds() ? hits.x : hits.y;
    return hits.x < hits.y && t > 0.0 ? t : -1.0;
}

// Cosine between a view ray and the vertical where it meets the sheet, and the width of a pixel there.
float slant(vec3 ray, vec3 up) { return max(abs(dot(ray, up)), 0.1); }
float pixel_on_clouds(float distance, float cosine) { return distance * pixel_angle() * inversesqrt(cosine); }

// Whether there may be cloud on a view ray before `end`: where not, `cloudiness` is 0.
bool may_meet_clouds(vec3 ray, float end) {
    float t = distance_to_clouds(ray);
    vec3 up = normalize(shading.camera + ray * t);
    return t >= 0.0 && t < end && mapped_clouds(up, pixel_on_clouds(t, slant(ray, up))) >= -DETAIL_MOST;
}

// Share of the light of stars that the clouds let through along a view ray.
float starlight_through_clouds(vec3 ray) {
    float t = distance_to_clouds(ray);
    if (!has_clouds() || t < 0.0) return 1.0;
    vec3 up = normalize(shading.camera + ray * t);
    float cosine = slant(ray, up), coarse;
    return exp(-shading.cloud_depth * cloudiness(up, pixel_on_clouds(t, cosine), coarse) / cosine);
}

// Share of light that a sheet of some optical depth throws back.
float cloud_reflectance(float depth) { return depth / (depth + HALF_REFLECTED); }

// Share of the sun's light that the clouds let through to a site `height` metres above the datum.
float cloud_shadow(vec3 from_centre, float height, float elevation, float footprint) {
    float above = shading.cloud_height - height;
    if (!has_clouds() || above <= 0.0 || elevation <= -0.05) return 1.0;
    float r = shading.radius + height, b = r * elevation, q = above * (2.0 * r + above);
    float way = q / (b + sqrt(b * b + q));
    // The sun's disc blurs shadows by a hundredth of the way.
    float depth = shading.cloud_depth * cloudiness_coarse(normalize(from_centre + shading.sun * way), max(footprint, 0.01 * way));
    return 1.0 - cloud_reflectance(depth / max(elevation, 0.1));
}

#endif
