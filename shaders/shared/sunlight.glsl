// Sunlight that arrives at points in the air or on the ground. Binds the table of transmittance.

#ifndef TERRANE_SUNLIGHT
#define TERRANE_SUNLIGHT
#include "air.glsl"

layout(binding = 10) uniform sampler2D transmittance;

// Share of the sunlight that arrives at a level, where the sun's elevation has sine `c`.
vec3 sun_share(Level level, float c) {
    float visible = sun_visibility(level, c);
    if (visible <= 0.0) return vec3(0.0);
    level = level.height > thickness() ? level_at(thickness()) : level;
    vec2 at = transmittance_coordinates(level, c);
    return visible * textureLod(transmittance, to_texels(at, textureSize(transmittance, 0)), 0.0).rgb;
}

// Irradiance of the sun on a surface that faces it, `height` metres above the datum, where the sun's elevation has sine `c`.
vec3 sun_irradiance(float height, float c) {
    if (!has_air()) return vec3(SUN * smoothstep(-SUN_RADIUS, SUN_RADIUS, c));
    return SUN * sun_share(level_at(max(height - shading.air_bottom, 0.0)), c);
}

#endif
