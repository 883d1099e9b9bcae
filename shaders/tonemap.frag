#version 460
// From radiance to an 8-bit picture: exposure, a filmic curve, our own sRGB encoding, and a dither of one step against banding, which
// is a function of the pixel alone.
//
// The curve is that of AgX (Sobotka 2022) in Wrensch's fit: channels are mixed a little before it and unmixed after it, so that bright
// colours pale towards white instead of turning to another hue, as the yellow and cyan of curves on each channel alone. Its
// result is encoded already. Contrast and saturation are about those of its look "punchy".
#include "shading.glsl"
#include "edges.glsl"

layout(binding = 1) uniform sampler2D radiance;
layout(binding = 3) uniform sampler2D edges;
layout(scalar, binding = 2) readonly buffer Exposure { float factor; };

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

// The encoded display value of a radiance.
vec3 filmic(vec3 color) {
    vec3 x = clamp((log2(max(TONE_MIX * color, 1e-10)) - TONE_RANGE.x) / (TONE_RANGE.y - TONE_RANGE.x), 0.0, 1.0);
    vec3 x2 = x * x, x4 = x2 * x2;
    x = TONE_CURVE[0] * x4 * x2 + TONE_CURVE[1] * x4 * x + TONE_CURVE[2] * x4 + TONE_CURVE[3] * x2 * x + TONE_CURVE[4] * x2
        + TONE_CURVE[5] * x + TONE_CURVE[6];
    x = pow(max(x, 0.0), vec3(TONE_CONTRAST));
    float grey = dot(x, LUMINANCE);
    return clamp(TONE_UNMIX * (grey + TONE_SATURATION * (x - grey)), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

vec3 shown_at(ivec2 pixel) {
    vec3 color = texelFetch(radiance, pixel, 0).rgb;
    if (is_plain(shading.mode)) return color;
    if (shading.mode == MODE_ALBEDO) return encode_srgb(clamp(color, 0.0, 1.0));
    float exposure = shading.adaptation < 0.0 ? shading.exposure : shading.exposure * factor;
    return filmic(color * exposure);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 shown = shown_at(pixel);
    float share;
    ivec2 neighbour;
    bool edge = decode_edge(texelFetch(edges, pixel, 0).r, share, neighbour) && !is_plain(shading.mode);
    // A loop of one turn at most: software renderers run the bodies of all conditions.
    for (float left = edge ? share : 0.0; left > 0.0; left -= 1.0) {
        // Mixed as encoded: so edges look equally wide on both sides.
        shown = mix(shown, shown_at(clamp(pixel + neighbour, ivec2(0), textureSize(radiance, 0) - 1)), share);
    }
    if (is_plain(shading.mode)) {
        out_color = vec4(shown, 1.0);
        return;
    }
    float dither = fract(DITHER.z * fract(dot(shading.window.xy + gl_FragCoord.xy, DITHER.xy))) - 0.5;
    out_color = vec4(shown + dither / 255.0, 1.0);
}
