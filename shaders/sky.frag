#version 460
// The air between the eye and whatever it sees, or space and the sun's disc where it sees nothing.
#include "eye_air.glsl"
#include "skylight.glsl"
#include "clouds.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D water;
layout(scalar, binding = 3) uniform View { FrameView view; };
layout(binding = 4) uniform sampler2D ground;

// What lies before a pixel: nothing, clear air (1), or clouds, too (2).
layout(constant_id = 0) const int BEFORE = 2;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

// Largest radiance that is drawn: half floats end there.
const float BRIGHTEST = 6e4;

// The sun's disc, darker towards its limb and redder (Hestroffer and Magnan 1998); its edge as wide as a pixel.
vec3 sun_disc(vec3 ray) {
    vec3 chord = ray - shading.sun;
    float pixel = pixel_angle();
    float radius = max(SUN_RADIUS, 0.5 * pixel), distance = length(chord);
    float seen = 1.0 - smoothstep(radius - 0.5 * pixel, radius + 0.5 * pixel, distance);
    if (seen <= 0.0) return vec3(0.0);
    float cosine = sqrt(max(1.0 - distance * distance / (radius * radius), 0.0));
    vec3 darkening = pow(vec3(max(cosine, 0.05)), vec3(0.4, 0.5, 0.65));
    return SUN / (PI * radius * radius) * seen * darkening;
}

// Its glare on the sky about it, without which the disc would be a hole punched into paper; as far as the planet does not hide it.
vec3 sun_glare(vec3 ray) {
    vec3 chord = ray - shading.sun;
    float visible = sun_visibility(level_at(max(shading.height_m - shading.air_bottom, 0.0)), dot(shading.vertical, shading.sun));
    float away = dot(chord, chord) + SUN_RADIUS * SUN_RADIUS;
    return vec3(SUN * visible * GLARE / (away * sqrt(away)));
}

// How high heaps of cloud rise over their edges in metres, for the light on them.
const float HEAP = 2500.0;
// Metres over which the sheet fades: about the eye, and where ground comes up to it.
const float NEAR_FADE = 5000.0;
const float GROUND_FADE = 500.0;
// What ground and sea below throw back to the base of clouds.
const float GROUND_LIGHT = 0.12;

// Radiance of the clouds that a view ray meets at `t`, and the share of light that they let through.
vec4 cloud_light(vec3 ray, float t) {
    vec3 up = normalize(shading.camera + ray * t);
    float elevation = dot(up, shading.sun), cosine = slant(ray, up), footprint = pixel_on_clouds(t, cosine);
    float coarse, here = cloudiness(up, footprint, coarse);
    if (here <= 0.0) return vec4(0.0, 0.0, 0.0, 1.0);
    vec3 sun = sun_irradiance(shading.cloud_height, elevation), sky = sky_irradiance(shading.cloud_height, elevation);
    float depth = shading.cloud_depth * here, level = max(elevation, 0.0), thrown_back = cloud_reflectance(depth / cosine);
    if (is_above_clouds()) {
        // Heaps are bright on the side of the sun.
        vec3 sunward = shading.sun - up * elevation;
        float across = length(sunward), step_m = max(1.5 * footprint, 6000.0);
        vec3 beside = normalize(up + sunward / max(across, 1e-3) * (step_m / (shading.radius + shading.cloud_height)));
        float slope = clamp(HEAP * (coarse - cloudiness_coarse(beside, footprint)) / step_m, -1.2, 1.2);
        float facing = max(elevation + slope * across, 0.0) * inversesqrt(1.0 + slope * slope);
        // A cloud hides what it does not throw back of the light from below by more than that: what it lets through, it blurs.
        return vec4((sun * mix(level, facing, 0.7) + sky) / PI * thrown_back, 1.0 - thrown_back);
    }
    float direct = exp(-depth / cosine), along_sun = depth / max(elevation, 0.1);
    float diffuse = max(1.0 - cloud_reflectance(along_sun) - exp(-along_sun), 0.0);
    // Thin cloud about the sun is bright: drops scatter forwards.
    float forward = mie_phase(dot(ray, shading.sun)) * (1.0 - direct) * exp(-0.5 * along_sun);
    vec3 base = GROUND_LIGHT * (sun * level + sky) * thrown_back;
    return vec4((sun * level * diffuse + sky * (1.0 - direct) * (1.0 - 0.6 * thrown_back) + base) / PI + sun * forward, direct);
}

// Puts the clouds before what a view ray sees at `end`, air included.
void add_clouds(vec3 ray, float end, Air air, inout vec3 color, inout float cover) {
    float t = distance_to_clouds(ray);
    if (t < 0.0 || t >= end) return;
    vec4 cloud = cloud_light(ray, t);
    if (cloud.a >= 1.0) return;
    air = nearer_air(air, t);
    float shown = smoothstep(0.0, NEAR_FADE, t) * clamp((end - t) / GROUND_FADE, 0.0, 1.0);
    cloud = mix(vec4(0.0, 0.0, 0.0, 1.0), cloud, shown);
    color = scattered(air) + air.passed * cloud.rgb + cloud.a * (color - scattered(air));
    cover = max(cover, 1.0 - cloud.a);
}

void main() {
    vec4 ground_color = texelFetch(water, ivec2(gl_FragCoord.xy), 0);
    float stored = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r;
    if (draws_diagram()) {
        out_color = vec4(ground_color.rgb, stored > 0.0 ? 1.0 : 0.0);
        return;
    }
    vec3 direction = view_ray(in_uv);
    float stretch = length(direction);
    vec3 ray = direction / stretch;
    float end = stored > 0.0 ? view.near / stored * stretch : 1e30;
    // The sea lies in front where the ground is under water, or where there is no ground at all.
    bool under_water = stored <= 0.0 || texelFetch(ground, ivec2(gl_FragCoord.xy), 0).a < 0.0;
    float sea = under_water ? distance_to_sea(ray) : -1.0;
    if (sea > 0.0) end = sea;
    bool empty = end >= 1e29;
    vec3 color = empty ? sun_disc(ray) + sun_glare(ray) : ground_color.rgb;
    Air air = Air(Way(0.0, 0.0, vec2(0.0)), vec3(1.0), vec3(0.0));
    if (BEFORE > 0) air = air_before(ray, end);
    // How much of what lies behind it is hidden, for pictures that are put before something else.
    float cover = empty ? 1.0 - dot(air.passed, LUMINANCE) : 1.0;
    color = color * air.passed + scattered(air);
    if (BEFORE == 2) add_clouds(ray, end, air, color, cover);
    out_color = vec4(min(color, BRIGHTEST), cover);
}
