// Light of the whole sky that arrives at points. Binds the table of the sky's irradiance.

#ifndef TERRANE_SKYLIGHT
#define TERRANE_SKYLIGHT
#include "sunlight.glsl"

layout(binding = 11) uniform sampler2D irradiance;

// Irradiance of the whole sky on level ground `height` metres above the datum, where the sun's elevation has sine `c`.
vec3 sky_irradiance(float height, float c) {
    if (!has_air()) return 0.3 * NIGHT;
    vec2 at = sun_coordinates(clamp(height - shading.air_bottom, 0.0, thickness()), c);
    return textureLod(irradiance, to_texels(at, textureSize(irradiance, 0)), 0.0).rgb + NIGHT;
}

#endif
