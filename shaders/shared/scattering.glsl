// Light that is scattered at a point. Binds the table of multiple scattering.

#ifndef TERRANE_SCATTERING
#define TERRANE_SCATTERING
#include "sunlight.glsl"

// Light that arrives by more than one scattering, from all sides alike, over the sun's irradiance.
layout(binding = 9) uniform sampler2D multiple;

// Scattered by molecules, or more than once; and by haze but for its phase function. Per metre, over the sun's irradiance.
struct Source {
    vec3 molecules;
    vec3 haze;
};

Source source_at(Medium medium, Level level, float c, float phase) {
    vec3 arriving = sun_share(level, c);
    vec3 again = textureLod(multiple, to_texels(sun_coordinates(level.height, c), textureSize(multiple, 0)), 0.0).rgb;
    return Source(medium.rayleigh * arriving * phase + (medium.rayleigh + medium.mie) * again, medium.mie * arriving);
}

#endif
