#version 460
// From radiance to an 8-bit picture: exposure, a filmic curve (fitted by Narkowicz 2015 to the ACES reference transform), our own
// sRGB encoding, and a dither of one step against banding. The dither is a function of the pixel alone.
#include "light.glsl"

layout(binding = 1) uniform sampler2D scene;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

vec3 filmic(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

void main() {
    vec3 color = texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb;
    if (light.mode == MODE_NORMALS || light.mode == MODE_DEPTH) {
        out_color = vec4(color, 1.0);
        return;
    }
    if (light.mode != MODE_ALBEDO) color = filmic(color * light.exposure);
    // Interleaved gradient noise (Jimenez 2014).
    float dither = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    out_color = vec4(encode_srgb(clamp(color, 0.0, 1.0)) + dither / 255.0, 1.0);
}
