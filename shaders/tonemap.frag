#version 460
// From radiance to an 8-bit picture: exposure, a filmic curve, our own sRGB encoding, and a dither of one step against banding, which
// is a function of the pixel alone.
//
// The curve is that of AgX (Sobotka 2022) in Wrensch's fit: channels are mixed a little before it and unmixed after it, so that bright
// colours pale towards white instead of turning to another hue, as the yellow and cyan of curves on each channel alone. Its
// result is encoded already. Contrast and saturation are about those of its look "punchy".
#include "light.glsl"

layout(binding = 1) uniform sampler2D scene;
layout(binding = 3) uniform sampler2D edges;
layout(scalar, binding = 2) readonly buffer Exposure { float factor; };

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

const mat3 MIX = mat3(0.936992, 0.016931, 0.016950, 0.031373, 0.951387, 0.031373, 0.031689, 0.031666, 0.951657);
const mat3 UNMIX = mat3(1.068485, -0.018402, -0.018424, -0.034099, 1.052838, -0.034102, -0.034445, -0.034420, 1.052547);
// Powers of two that the curve maps to black and white.
const vec2 RANGE = vec2(-12.47393, 4.026069);
const float CONTRAST = 1.4;
const float SATURATION = 1.35;

// The encoded display value of a radiance.
vec3 filmic(vec3 color) {
    vec3 x = clamp((log2(max(MIX * color, 1e-10)) - RANGE.x) / (RANGE.y - RANGE.x), 0.0, 1.0);
    vec3 x2 = x * x, x4 = x2 * x2;
    x = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    x = pow(max(x, 0.0), vec3(CONTRAST));
    float grey = dot(x, vec3(0.2126, 0.7152, 0.0722));
    return clamp(UNMIX * (grey + SATURATION * (x - grey)), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

// As in edges.frag.
const ivec2 NEIGHBOURS[8] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(1, 1), ivec2(-1, 1), ivec2(1, -1), ivec2(-1, -1));

vec3 shown_at(ivec2 pixel) {
    vec3 color = texelFetch(scene, pixel, 0).rgb;
    if (light.mode == MODE_NORMALS || light.mode == MODE_DEPTH) return color;
    if (light.mode == MODE_ALBEDO) return encode_srgb(clamp(color, 0.0, 1.0));
    float exposure = light.adaptation < 0.0 ? light.exposure : light.exposure * factor;
    return filmic(color * exposure);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 shown = shown_at(pixel);
    int edge = int(texelFetch(edges, pixel, 0).r * 255.0 + 0.5) - 1;
    if (edge >= 0) {
        // Mixed as encoded: so edges look equally wide on both sides.
        ivec2 other = clamp(pixel + NEIGHBOURS[edge % 8], ivec2(0), textureSize(scene, 0) - 1);
        shown = mix(shown, shown_at(other), float(edge / 8 + 1) / 8.0);
    }
    if (light.mode == MODE_NORMALS || light.mode == MODE_DEPTH) {
        out_color = vec4(shown, 1.0);
        return;
    }
    // Interleaved gradient noise (Jimenez 2014).
    float dither = fract(52.9829189 * fract(dot(light.window.xy + gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    out_color = vec4(shown + dither / 255.0, 1.0);
}
