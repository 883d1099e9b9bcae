#version 460
// From radiance to an 8-bit picture: exposure, a tone curve, our own sRGB encoding, and a dither of one step against banding, which is
// a function of the pixel alone.
//
// The usual curve is an S about middle grey on the luminance, so that hues stay, and then the shoulder of PBR Neutral (Khronos 2024) on
// the brightest channel, in which colours pale towards white instead of turning to another hue. The other is that of AgX (Sobotka 2022)
// in Wrensch's fit, whose result is encoded already. Its contrast and saturation are about those of its look "punchy".
#include "shading.glsl"
#include "edges.glsl"

layout(binding = 1) uniform sampler2D radiance;
layout(binding = 3) uniform sampler2D edges;
// As a uniform block, like all that every pixel reads: see shading.glsl.
layout(scalar, binding = 2) uniform Exposure { float factor; };

// Whether pixels on edges are drawn, or all without them.
layout(constant_id = 0) const int MIXED = 0;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

// What is brighter than the straight part reaches 1 only in the end, and pales on the way.
vec3 shoulder(vec3 color) {
    float peak = max(color.r, max(color.g, color.b));
    if (peak <= TONE_SHOULDER) return color;
    float room = 1.0 - TONE_SHOULDER;
    float lower = 1.0 - room * room / (peak + room - TONE_SHOULDER);
    float kept = 1.0 / (TONE_PALING * (peak - lower) + 1.0);
    return mix(vec3(lower), color * (lower / peak), kept);
}

vec3 neutral(vec3 color) {
    float luminance = max(dot(color, LUMINANCE), 1e-10);
    float above = log(luminance / TONE_GREY);
    vec2 bend = above < 0.0 ? TONE_SHADOWS : shading.bend.yz;
    float lift = bend.x * above * inversesqrt(1.0 + (above / bend.y) * (above / bend.y));
    float saturation = 1.0 + TONE_SATURATION * TONE_GREY / (TONE_GREY + luminance);
    // As a power of ratios: no channel falls below nothing, as it would by a factor on differences.
    vec3 vivid = luminance * pow(max(color, 0.0) / luminance, vec3(saturation));
    return shoulder(vivid * (shading.bend.x / TONE_GREY * exp(lift)));
}

vec3 agx(vec3 color) {
    vec3 x = clamp((log2(max(AGX_MIX * color * AGX_EXPOSURE, 1e-10)) - AGX_RANGE.x) / (AGX_RANGE.y - AGX_RANGE.x), 0.0, 1.0);
    vec3 x2 = x * x, x4 = x2 * x2;
    x = AGX_CURVE[0] * x4 * x2 + AGX_CURVE[1] * x4 * x + AGX_CURVE[2] * x4 + AGX_CURVE[3] * x2 * x + AGX_CURVE[4] * x2
        + AGX_CURVE[5] * x + AGX_CURVE[6];
    x = pow(max(x, 0.0), vec3(AGX_CONTRAST));
    float grey = dot(x, LUMINANCE);
    return clamp(AGX_UNMIX * (grey + AGX_SATURATION * (x - grey)), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

vec3 shown_at(ivec2 pixel) {
    vec3 color = texelFetch(radiance, pixel, 0).rgb;
    if (draws_plainly()) return color;
    if (mode_is(MODE_ALBEDO)) return encode_srgb(clamp(color, 0.0, 1.0));
    float exposure = decided_late(shading.adaptation < 0.0) ? shading.exposure : shading.exposure * factor;
    return decided_late(shading.tone == TONE_AGX) ? agx(color * exposure) : encode_srgb(neutral(color * exposure));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 shown = shown_at(pixel);
    if (MIXED == 1 && !draws_plainly()) {
        float share;
        ivec2 neighbour;
        decode_edge(texelFetch(edges, pixel, 0).r, share, neighbour);
        // Mixed as encoded: so edges look equally wide on both sides.
        shown = mix(shown, shown_at(clamp(pixel + neighbour, ivec2(0), textureSize(radiance, 0) - 1)), share);
    }
    if (draws_plainly()) {
        out_color = vec4(shown, 1.0);
        return;
    }
    float dither = fract(DITHER.z * fract(dot(shading.window.xy + gl_FragCoord.xy, DITHER.xy))) - 0.5;
    out_color = vec4(shown + dither / 255.0, 1.0);
}
