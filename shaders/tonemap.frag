#version 460
// From radiance to an 8-bit picture: exposure, a filmic curve, our own sRGB encoding, and a dither of one step against banding, which
// is a function of the pixel alone.
//
// The curve is that of AgX (Sobotka 2022) in Wrensch's fit: channels are mixed a little before it and unmixed after it, so that bright
// colours pale towards white instead of turning to another hue, as the yellow and cyan of curves on each channel alone. Its
// result is encoded already. Contrast and saturation are those of AgX's look "punchy", halved.
#include "light.glsl"

layout(binding = 1) uniform sampler2D scene;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

const mat3 MIX = mat3(0.842479062, 0.042328242, 0.042375655, 0.0784336, 0.878468636, 0.0784336, 0.079223745, 0.079166127, 0.879142974);
const mat3 UNMIX = mat3(1.196879005, -0.052896852, -0.052971636, -0.098020881, 1.151903130, -0.098043450, -0.099029744, -0.098961177, 1.151073673);
// Powers of two that the curve maps to black and white.
const vec2 RANGE = vec2(-12.47393, 4.026069);
const float CONTRAST = 1.2;
const float SATURATION = 1.3;

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

void main() {
    vec3 color = texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb;
    if (light.mode == MODE_NORMALS || light.mode == MODE_DEPTH) {
        out_color = vec4(color, 1.0);
        return;
    }
    vec3 shown = light.mode == MODE_ALBEDO ? encode_srgb(clamp(color, 0.0, 1.0)) : filmic(color * light.exposure);
    // Interleaved gradient noise (Jimenez 2014).
    float dither = fract(52.9829189 * fract(dot(light.window.xy + gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    out_color = vec4(shown + dither / 255.0, 1.0);
}
