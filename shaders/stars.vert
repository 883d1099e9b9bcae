#version 460
// Stars: a quad each, over the sky. A catalogue made of hashes: positions without order, magnitudes as many as there are to the
// naked eye (ten to the power of 0.51 more with each, 9,000 down to 6.5), colours of black bodies of 3,300 to 20,000 K.
#include "eye_air.glsl"
#include "clouds.glsl"

layout(location = 0) out vec2 out_offset;
layout(location = 1) flat out vec3 out_radiance;

const float FAINTEST = 6.5;
const float GROWTH = 0.51;
// Irradiance of a star of magnitude 0. Far more than true against the sun, for pictures show a millionth of the range of the eye; so
// skies by day have to hide what they would outshine.
const float MAGNITUDE_0 = 1.0e-6;
const float HIDING_LUMINANCE = 0.03;
// Pixels from the centre to the quad's edge, and angle that a pixel covers at least: stars must not grow bright without end in a
// telescope.
const float REACH = 2.0;
const float FINEST_PIXEL = 2e-5;

// PCG (Jarzynski and Olano 2020).
uvec3 hash(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v += v.yzx * v.zxy;
    v ^= v >> 16u;
    return v + v.yzx * v.zxy;
}

vec3 black_body(float mireds) {
    // Wien's law at the wavelengths of the primaries, against the sun's 172 mireds, as bright in green.
    return exp((mireds - 172.0) * vec3(2.573e-3, 0.0, -4.782e-3));
}

void main() {
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    out_offset = vec2(0.0);
    out_radiance = vec3(0.0);
    uint star = uint(gl_InstanceIndex);
    vec3 random = vec3(hash(uvec3(star, 77u, 13u))) / 4294967296.0;
    float z = 2.0 * random.x - 1.0, turn = 2.0 * PI * random.y;
    vec3 ray = vec3(sqrt(1.0 - z * z) * vec2(cos(turn), sin(turn)), z);
    float ahead = dot(ray, shading.forward);
    if (ahead <= 0.0 || distance_to_sea(ray) > 0.0) return;

    float magnitude = FAINTEST + log2((float(star) + 0.5) / float(STARS)) / (log2(10.0) * GROWTH);
    Air air = air_before(ray, 1e30);
    float daylight = dot(scattered(air), LUMINANCE) / HIDING_LUMINANCE;
    vec2 pixel = vec2(2.0) / shading.size;
    float angle = max(length(shading.up) * pixel.y, FINEST_PIXEL);
    out_radiance = MAGNITUDE_0 * exp2(-0.4 * log2(10.0) * magnitude) * black_body(mix(50.0, 300.0, random.z)) * air.passed * starlight_through_clouds(ray)
        / (angle * angle * (1.0 + daylight * daylight));

    out_offset = REACH * (vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 1.0);
    vec2 at = vec2(dot(ray, shading.right) / dot(shading.right, shading.right), -dot(ray, shading.up) / dot(shading.up, shading.up)) / ahead;
    gl_Position = vec4(in_window(at + out_offset * pixel), 0.0, 1.0);
}
