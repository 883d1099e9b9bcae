#version 460
// Edges at one sample a pixel, first half: between which pixels there are any. An invocation looks at 32 pixels of ROWS rows.
//
// Reversed depth is affine over a plane in the picture, so depth that goes on at the rate at which it changes on either side is one
// surface, however grazing. Sky, sea and ground are told apart before depth is compared.
#include "shading.glsl"
#include "edge_planes.glsl"

layout(local_size_x = 64) in;
layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;
layout(scalar, binding = 3) writeonly buffer EdgeBits { uint bits[]; };

const int ROWS = 4;
// Surfaces are apart where depth jumps by more than this share of itself, and by so many times its change on either side.
const float LEAST_JUMP = 0.02;
const float STEEPER = 3.0;
// Stands for the depth of the sea where there is no ground below it in the picture.
const float OPEN_SEA = 1e-20;

bool has_sea() {
    return shading.sea_level > NO_SEA && shading.height_m > shading.sea_level && !is_diagram(shading.mode);
}

// What a pixel shows: depth of ground, negative under water; 0 is the sky.
float surface(ivec2 pixel, bool sea, ivec2 size) {
    pixel = clamp(pixel, ivec2(0), size - 1);
    float found = texelFetch(depth, pixel, 0).r;
    bool under = sea && texelFetch(ground, pixel, 0).a < 0.0;
    if (under) found = -found;
    // A loop of one turn: software renderers run the bodies of all conditions.
    for (bool open = sea && found == 0.0; open; open = false) {
        vec3 ray = view_ray((vec2(pixel) + 0.5) / vec2(size));
        if (distance_to_sea(normalize(ray)) > 0.0) found = -OPEN_SEA;
    }
    return found;
}

// Whether b, then d, lie behind a, behind which on this side is c, by a jump.
bool jumps(float near, float far, float beyond_near, float beyond_far) {
    float jump = near - far, slope = max(beyond_near - near, far - beyond_far);
    return jump > max(LEAST_JUMP * near, STEEPER * slope);
}

// Edges between pixels b and c of a, b, c, d in a row: x if c is nearer, y if b is, z for the waterline.
uvec3 between(float a, float b, float c, float d) {
    float da = abs(a), db = abs(b), dc = abs(c), dd = abs(d);
    bool sky = b == 0.0 || c == 0.0, sea = b < 0.0 && c < 0.0;
    bool c_nearer = dc > db && !sea && (sky || jumps(dc, db, dd, da));
    bool b_nearer = db > dc && !sea && (sky || jumps(db, dc, da, dd));
    bool shore = !sky && (b < 0.0) != (c < 0.0) && !c_nearer && !b_nearer;
    return uvec3(c_nearer, b_nearer, shore);
}

void main() {
    ivec2 size = textureSize(depth, 0);
    int words = words_of(size), number = int(gl_GlobalInvocationID.x);
    int word = number % words, top = number / words * ROWS;
    if (top >= size.y) return;
    bool sea = has_sea();
    uint found[PLANES][ROWS];
    for (int r = 0; r < ROWS; ++r) {
        for (int plane = 0; plane < PLANES; ++plane) found[plane][r] = 0u;
    }
    // Of the rows, the pixels at x - 1, x and x + 1 before the turn.
    float before[ROWS], here[ROWS], after[ROWS];
    for (int r = 0; r < ROWS; ++r) {
        ivec2 pixel = ivec2(32 * word, top + r);
        before[r] = surface(pixel - ivec2(1, 0), sea, size);
        here[r] = surface(pixel, sea, size);
        after[r] = surface(pixel + ivec2(1, 0), sea, size);
    }
    int last = min(32, size.x - 32 * word);
    for (int k = 0; k < last; ++k) {
        int x = 32 * word + k;
        float column[ROWS + 3];
        column[0] = surface(ivec2(x, top - 1), sea, size);
        for (int r = 0; r < ROWS; ++r) column[r + 1] = here[r];
        column[ROWS + 1] = surface(ivec2(x, top + ROWS), sea, size);
        column[ROWS + 2] = surface(ivec2(x, top + ROWS + 1), sea, size);
        for (int r = 0; r < ROWS; ++r) {
            float next = surface(ivec2(x + 2, top + r), sea, size);
            uvec3 below = between(column[r], column[r + 1], column[r + 2], column[r + 3]) << k;
            uvec3 right = between(before[r], here[r], after[r], next) << k;
            found[BELOW_NEARER][r] |= below.x;
            found[ABOVE_NEARER][r] |= below.y;
            found[SHORE_BELOW][r] |= below.z;
            found[RIGHT_NEARER][r] |= right.x;
            found[LEFT_NEARER][r] |= right.y;
            found[SHORE_RIGHT][r] |= right.z;
            before[r] = here[r];
            here[r] = after[r];
            after[r] = next;
        }
    }
    for (int r = 0; r < ROWS && top + r < size.y; ++r) {
        for (int plane = 0; plane < PLANES; ++plane) bits[word_index(size, plane, word, top + r)] = found[plane][r];
    }
}
