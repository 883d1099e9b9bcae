// The sky as sites on the sea or the ground see it, for reflections.

#ifndef TERRANE_MIRRORED_SKY
#define TERRANE_MIRRORED_SKY
#include "eye_air.glsl"

// Radiance of the sky of a site from an upward direction, without the sun's disc. `up` is the site's vertical, `irradiance` that
// of the sky there (skylight.glsl). For eyes low in the air it is the eye's sky turned to the site's
// vertical; from higher up, where that is darker than the site's, a gradient with the brightness of the site's sky.
vec3 mirrored_sky(vec3 direction, vec3 up, vec3 irradiance) {
    float low = has_air() ? 1.0 - smoothstep(0.25, 1.0, shading.height_m / shading.scale_height) : 0.0;
    vec3 seen = vec3(0.0);
    if (low > 0.0) {
        seen = sky_radiance(normalize(direction + cross(cross(up, shading.vertical), direction)));
        if (low >= 1.0) return seen;
    }
    float towards_zenith = pow(max(dot(direction, up), 0.0), 0.4);
    vec3 shape = mix(vec3(1.6, 1.45, 1.3), vec3(0.65, 0.75, 0.85), towards_zenith);
    return mix(irradiance / PI * shape, seen, low);
}

#endif
