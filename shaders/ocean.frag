#version 460
// The sea: the sphere at sea level, met by every view ray in closed form; waves in its normals, what a pixel cannot resolve of them as
// roughness, so that glitter widens with distance. Whether ground is under water comes from its
// texture and not from the mesh, which may be coarser than the water is deep, so that coasts are sharp at every altitude.
#include "mirrored_sky.glsl"
#include "skylight.glsl"
#include "clouds.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

layout(binding = 3) uniform sampler2DArray waves;

// How fast the maps of the cascades drift in metres a second, and where to.
const vec2 DRIFT[3] = vec2[](vec2(6.0, 4.1), vec2(2.4, 1.2), vec2(0.9, -0.3));
// Reflectance of foam.
const vec3 FOAM = vec3(0.55, 0.58, 0.6);

// Width in metres of the pattern of gusts, and by how many powers of two they change the waves' variance, one deviation.
const float GUSTS = 6000e3;
const float GUSTINESS = 0.22;

// Factor on the variance of slopes: where the wind is stronger the sea is rougher, which shows in the sun's glitter from orbit. The
// pattern is that of the shortest waves, stretched.
float gusts(vec3 up) {
    vec2 at = (up.xy + up.z * vec2(0.6, 0.8)) * shading.radius / GUSTS;
    vec3 found = textureLod(waves, vec3(at, 2.0), 1.0).xyz;
    return exp2(GUSTINESS * (found.x + found.y) * inversesqrt(found.z));
}

// Slopes of the waves that a pixel resolves, as a gradient in space, and the variance of the slopes of those that it does not.
vec3 wave_slopes(vec3 from_camera, vec3 up, float footprint, out float variance) {
    vec3 position = in_periods(from_camera), weights = axis_weights(up), gradient = vec3(0.0);
    float texels = footprint * float(textureSize(waves, 0).x) / REPEAT_M, resolved = 0.0;
    vec3 lods = log2(texels * vec3(WAVE_COPIES[0], WAVE_COPIES[1], WAVE_COPIES[2]));
    int tiles = resolved_tiles(lods, 7.0);
    for (uint axes = counted_axes(weights); axes != 0u;) {
        int axis = next_axis(axes);
        for (int k = 0; k < tiles; ++k) {
            vec2 at = (coordinates_along(axis, position) - DRIFT[k] * shading.time / REPEAT_M) * WAVE_COPIES[k];
            vec3 found = textureLod(waves, vec3(at, float(k)), lods[k]).xyz;
            gradient += weights[axis] * gradient_along(axis, found.xy);
            resolved += weights[axis] * found.z;
        }
    }
    variance = max(shading.sea_variance * gusts(up) - resolved, 0.004);
    return gradient - up * dot(gradient, up);
}

// Share of light that a sea of some roughness reflects (Bruneton, Neyret and Holzschuch 2010); `c` is the cosine against its mean.
float sea_fresnel(float c, float variance) {
    float deviation = sqrt(variance);
    return 0.02 + 0.98 * pow(1.0 - c, 5.0 * exp(-2.69 * deviation)) / (1.0 + 22.7 * deviation * sqrt(deviation));
}

// Sun mirrored by facets whose slopes are spread around those of the resolved waves (Ross, Dion and Potvin 2005).
float glitter(vec3 ray, vec3 up, vec3 slopes, float variance) {
    vec3 half_way = normalize(shading.sun - ray);
    float upright = dot(half_way, up);
    if (upright <= 0.05) return 0.0;
    vec3 missing = up - half_way / upright - slopes;
    // Half the variance goes each way.
    float density = exp(-dot(missing, missing) / variance) / (PI * variance);
    float fresnel = 0.02 + 0.98 * pow(1.0 - clamp(dot(shading.sun, half_way), 0.0, 1.0), 5.0);
    return fresnel * density / (4.0 * upright * upright * upright * upright * max(-dot(ray, up), 0.06));
}

void main() {
    vec4 ground_color = texelFetch(ground, ivec2(gl_FragCoord.xy), 0);
    out_color = vec4(ground_color.rgb, 1.0);
    if (decided_late(shading.sea_level <= NO_SEA) || draws_diagram()) return;
    bool is_ground = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r > 0.0;
    if (is_ground && ground_color.a >= 0.0) return;

    vec3 ray = normalize(view_ray(in_uv));
    float t = distance_to_sea(ray);
    if (t < 0.0) return;

    vec3 from_centre = shading.camera + ray * t, up = normalize(from_centre);
    float elevation = dot(up, shading.sun), grazing = max(-dot(ray, up), 0.0);
    // As long as a pixel is wide, and half as long as it is deep: what lies between becomes roughness.
    float pixel = t * pixel_angle();
    float variance;
    float footprint = pixel / sqrt(max(grazing, 0.02));
    vec3 slopes = wave_slopes(ray * t, up, footprint, variance);
    vec3 normal = normalize(up - slopes);

    // The water's depth below the surface point, and along the ray, which the surface bends.
    float water_depth = is_ground ? max(-ground_color.a, 0.0) : SHORE_RANGE;
    float under = water_depth / sqrt(1.0 - 0.56 * (1.0 - grazing * grazing));
    vec3 absorbed = exp(-under * vec3(0.35, 0.075, 0.06) * 0.7);
    vec3 sun = sun_irradiance(shading.sea_level, elevation) * cloud_shadow(from_centre, shading.sea_level, elevation, footprint);
    vec3 sky = sky_irradiance(shading.sea_level, elevation);
    vec3 lit = (sun * max(elevation, 0.0) + sky) / PI;
    vec3 body = mix(shading.shallow, shading.deep, 1.0 - exp(-water_depth / 25.0)) * lit * (1.0 - absorbed) + ground_color.rgb * absorbed;

    // Facets that face away are not seen: the mirrored sky is that above the mean.
    float fresnel = sea_fresnel(clamp(-dot(ray, normal), 0.0, 1.0), variance);
    vec3 bounced = reflect(ray, normal);
    bounced = normalize(bounced + up * max(0.0, 0.7 * sqrt(variance) - dot(bounced, up)));
    vec3 mirrored = mirrored_sky(bounced, up, sky) * fresnel + sun * glitter(ray, up, slopes, variance);

    // The edge of the water breaks in lines that the waves bend.
    float edge = water_depth + 6.0 * dot(slopes, vec3(1.0)) * min(1.0, water_depth);
    float foam = 0.7 * smoothstep(0.7, 0.1, edge) * smoothstep(0.0, 0.1, water_depth);
    out_color = vec4(mix(body * (1.0 - fresnel) + mirrored, FOAM * lit, foam), 1.0);
}
