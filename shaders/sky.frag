#version 460
// The air between the eye and whatever it sees, or space and the sun's disc where it sees nothing.
#include "eye_air.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D scene;
layout(scalar, binding = 3) readonly buffer View { FrameView view; };
layout(binding = 4) uniform sampler2D ground;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

// Largest radiance that is drawn: half floats end there.
const float BRIGHTEST = 6e4;

// The sun's disc, darker towards its limb and redder (Hestroffer and Magnan 1998); its edge as wide as a pixel.
vec3 sun_disc(vec3 ray) {
    vec3 chord = ray - light.sun;
    float pixel = 2.0 * length(light.up) / light.size.y;
    float radius = max(SUN_RADIUS, 0.5 * pixel), distance = length(chord);
    float seen = 1.0 - smoothstep(radius - 0.5 * pixel, radius + 0.5 * pixel, distance);
    if (seen <= 0.0) return vec3(0.0);
    float cosine = sqrt(max(1.0 - distance * distance / (radius * radius), 0.0));
    vec3 darkening = pow(vec3(max(cosine, 0.05)), vec3(0.4, 0.5, 0.65));
    return SUN / (PI * radius * radius) * seen * darkening;
}

void main() {
    vec4 ground_color = texelFetch(scene, ivec2(gl_FragCoord.xy), 0);
    float stored = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r;
    if (is_diagram()) {
        out_color = vec4(ground_color.rgb, stored > 0.0 ? 1.0 : 0.0);
        return;
    }
    vec3 direction = view_ray(in_uv);
    float stretch = length(direction);
    vec3 ray = direction / stretch;
    float end = stored > 0.0 ? view.near / stored * stretch : 1e30;
    // The sea lies in front where the ground is under water, or where there is no ground at all.
    bool water = stored <= 0.0 || texelFetch(ground, ivec2(gl_FragCoord.xy), 0).a < 0.0;
    float sea = water ? distance_to_sea(ray) : -1.0;
    if (sea > 0.0) end = sea;
    bool empty = end >= 1e29;
    vec3 color = empty ? sun_disc(ray) : ground_color.rgb;
    vec3 scattered, passed;
    air_before(ray, end, scattered, passed);
    // How much of what lies behind it is hidden, for pictures that are put before something else.
    float cover = empty ? 1.0 - dot(passed, vec3(0.2126, 0.7152, 0.0722)) : 1.0;
    out_color = vec4(min(color * passed + scattered, BRIGHTEST), cover);
}
