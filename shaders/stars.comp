#version 460
// Stars, one an invocation: how bright each is and where in the picture. A catalogue made of hashes: positions without order, magnitudes
// as many as there are to the naked eye (ten to the power of 0.51 more with each, 9,000 down to 6.5), colours of black bodies of 3,300 to
// 20,000 K.
#include "eye_air.glsl"
#include "clouds.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 1) writeonly buffer Stars { Star stars[]; };

const float FAINTEST = 6.5;
const float GROWTH = 0.51;
// Irradiance of a star of magnitude 0. Far more than true against the sun, for pictures show a millionth of the range of the eye; so
// skies by day have to hide what they would outshine.
const float MAGNITUDE_0 = 1.0e-6;
const float HIDING_LUMINANCE = 0.03;
// Angle that a pixel covers at least: stars must not grow bright without end in a telescope.
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
    uint star = gl_GlobalInvocationID.x;
    if (star >= STARS) return;
    vec3 random = vec3(hash(uvec3(star, 77u, 13u))) / 4294967296.0;
    float z = 2.0 * random.x - 1.0, turn = 2.0 * PI * random.y;
    vec3 ray = vec3(sqrt(1.0 - z * z) * vec2(cos(turn), sin(turn)), z);
    float ahead = dot(ray, shading.forward);
    vec2 at = vec2(dot(ray, shading.right) / dot(shading.right, shading.right), -dot(ray, shading.up) / dot(shading.up, shading.up)) / ahead;
    // Far outside of the picture, whatever the star's width.
    stars[star] = Star(vec2(9.0), vec3(0.0));
    if (ahead <= 0.0 || distance_to_sea(ray) > 0.0) return;

    float magnitude = FAINTEST + log2((float(star) + 0.5) / float(STARS)) / (log2(10.0) * GROWTH);
    Air air = air_before(ray, 1e30);
    float daylight = dot(scattered(air), LUMINANCE) / HIDING_LUMINANCE;
    float angle = max(pixel_angle(), FINEST_PIXEL);
    vec3 radiance = MAGNITUDE_0 * exp2(-0.4 * log2(10.0) * magnitude) * black_body(mix(50.0, 300.0, random.z)) * air.passed * starlight_through_clouds(ray)
        / (angle * angle * (1.0 + daylight * daylight));
    stars[star] = Star(at, radiance);
}
