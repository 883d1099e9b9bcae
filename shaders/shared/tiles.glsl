// Where maps that repeat over the whole planet are looked up: along the three axes of the planet, so that nothing swims when the
// camera moves, each as far as the ground faces it.

#ifndef TERRANE_TILES
#define TERRANE_TILES
#include "shading.glsl"

// How much each axis counts where the vertical is `up`: 1 together.
vec3 axis_weights(vec3 up) {
    vec3 w = abs(up);
    w = w * w;
    w = w * w;
    w = max(w * w - 0.01, 0.0);
    return w / (w.x + w.y + w.z);
}

// The axes that count, as bits. Loops over them take one turn nearly everywhere; software renderers skip turns of loops, but not the
// bodies of conditions that are false.
uint counted_axes(vec3 weights) {
    uvec3 counts = uvec3(greaterThan(weights, vec3(0.0)));
    return counts.x | counts.y << 1u | counts.z << 2u;
}

// Takes the first axis out of what `counted_axes` found.
int next_axis(inout uint axes) {
    int axis = findLSB(axes);
    axes &= axes - 1u;
    return axis;
}

// How many of three tiles a pixel resolves something of: those whose level of detail, coarsest tile first, is below a limit.
int resolved_tiles(vec3 lods, float limit) { return int(dot(vec3(lessThan(lods, vec3(limit))), vec3(1.0))); }

// A position relative to the camera in periods of REPEAT_M, exact near the camera.
vec3 in_periods(vec3 from_camera) { return (shading.anchor + from_camera) / REPEAT_M; }

// Slopes of a map seen along axis k, as a gradient in space.
vec3 gradient_along(int k, vec2 slopes) {
    return k == 0 ? vec3(0.0, slopes) : k == 1 ? vec3(slopes.y, 0.0, slopes.x) : vec3(slopes, 0.0);
}

// Map coordinates of a position seen along axis k.
vec2 coordinates_along(int k, vec3 position) { return k == 0 ? position.yz : k == 1 ? position.zx : position.xy; }

#endif
