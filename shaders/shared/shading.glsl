// What shading knows of planet, camera and sun, and where view rays meet spheres about the planet. Metres, planet-fixed directions.

#ifndef TERRANE_SHADING
#define TERRANE_SHADING
#extension GL_EXT_scalar_block_layout : require
#include "layout.glsl"

// A uniform block: software renderers read these once for a group of pixels, and storage blocks once for each pixel and use.
layout(scalar, binding = 0) uniform ShadingBlock { Shading shading; };

// A condition on uniforms alone. Mesa's software renderer writes uniforms that conditions depend on into the shader as constants, and so
// compiles it again for every frame (lavapipe's inlined uniforms), unless something else counts, too; `&&` would be a condition of its own.
bool decided_late(bool condition) { return all(bvec2(condition, ALWAYS)); }

const float PI = 3.14159265;

bool has_air() { return decided_late(shading.scale_height > 0.0); }

bool mode_is(uint mode) { return decided_late(shading.mode == mode); }
bool draws_diagram() { return decided_late(is_diagram(shading.mode)); }
bool draws_plainly() { return decided_late(is_plain(shading.mode)); }

// Whether the camera is so far away that the squares of its distance and of the planet's radius cannot be compared.
bool is_afar() { return decided_late(shading.height_m > shading.radius); }

// Where a ray from the camera enters and leaves the ball of a radius `above` metres over the datum; x > y if it misses.
vec2 through_shell(vec3 ray, float above) {
    float r = shading.radius + shading.height_m;
    float shell = shading.radius + above;
    float b = dot(ray, shading.vertical) * r;
    // r² - shell², without the cancellation.
    float c = (shading.height_m - above) * (r + shell);
    float discriminant = b * b - c;
    if (is_afar()) {
        // By how much the ray passes beside the centre.
        float aside = length(cross(shading.camera, ray));
        discriminant = (shell - aside) * (shell + aside);
    }
    if (discriminant < 0.0) return vec2(1.0, -1.0);
    float root = sqrt(discriminant);
    float q = b > 0.0 ? -b - root : -b + root;
    vec2 hits = vec2(q, c / q);
    return vec2(min(hits.x, hits.y), max(hits.x, hits.y));
}

// Distance to the sea along a view ray; negative if it does not meet the sea's surface from above.
float distance_to_sea(vec3 ray) {
    if (decided_late(shading.sea_level <= NO_SEA) || decided_late(shading.height_m <= shading.sea_level)) return -1.0;
    vec2 hits = through_shell(ray, shading.sea_level);
    return hits.x < hits.y && hits.y > 0.0 ? hits.x : -1.0;
}

// View ray of a point in the window at uv in [0, 1], not normalised: its length per unit of distance along the view axis.
vec3 view_ray(vec2 uv) {
    vec2 screen = (shading.window.xy + uv * shading.window.zw) / shading.size * 2.0 - 1.0;
    return shading.forward + shading.right * screen.x - shading.up * screen.y;
}

// Width of a pixel at a metre along the view axis, in metres.
float pixel_angle() { return 2.0 * length(shading.up) / shading.size.y; }

// Where a point of the picture lies in the window; both from -1 to 1, y down.
vec2 in_window(vec2 screen) {
    return ((screen * 0.5 + 0.5) * shading.size - shading.window.xy) / shading.window.zw * 2.0 - 1.0;
}

#endif
