#version 460
// The air: light scattered between the eye and whatever it sees, or space and the sun's disc where it sees nothing.
#include "light.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D scene;
layout(scalar, binding = 3) readonly buffer View { FrameView view; };
layout(binding = 4) uniform sampler2D ground;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

vec3 sun_disc(vec3 ray) {
    float c = dot(ray, light.sun);
    float edge = smoothstep(0.99998, 0.999992, c);
    return vec3(SUN * 400.0) * edge;
}

void main() {
    vec4 ground_color = texelFetch(scene, ivec2(gl_FragCoord.xy), 0);
    if (light.mode == MODE_NORMALS || light.mode == MODE_ALBEDO || light.mode == MODE_DEPTH) {
        out_color = ground_color;
        return;
    }
    vec3 direction = view_ray(in_uv);
    float stretch = length(direction);
    vec3 ray = direction / stretch;
    float stored = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r;
    float end = stored > 0.0 ? view.near / stored * stretch : 1e30;
    // The sea lies in front where the ground is under water, or where there is no ground at all.
    bool water = stored <= 0.0 || texelFetch(ground, ivec2(gl_FragCoord.xy), 0).a < 0.0;
    float sea = water ? distance_to_sea(ray) : -1.0;
    if (sea > 0.0) end = sea;
    bool empty = end >= 1e29;
    vec3 color = empty ? sun_disc(ray) : ground_color.rgb;
    if (has_air()) {
        vec2 shell = through_shell(ray, light.air_top);
        float from = max(shell.x, 0.0);
        float to = min(shell.y, end);
        if (shell.x < shell.y && from < to) {
            vec3 scattered, transmittance;
            march(ray, from, to, scattered, transmittance);
            color = color * transmittance + scattered;
        }
    }
    out_color = vec4(color, 1.0);
}
