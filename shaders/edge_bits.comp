#version 460
// Edges at one sample a pixel, second part: between which pixels there are any. An invocation looks at 32 pixels of EDGE_ROWS rows.
//
// Reversed depth is affine over a plane in the picture, so depth that goes on at the rate at which it changes on either side is one
// surface, however grazing. Sky, sea and ground are told apart before depth is compared.
#include "shading.glsl"
#include "edge_planes.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(scalar, binding = 3) buffer EdgeBits { uint bits[]; };

// Surfaces are apart where depth jumps by more than this share of itself, and by so many times its change on either side.
const float LEAST_JUMP = 0.02;
const float STEEPER = 3.0;

ivec2 size;

float depth_at(int x, int y) { return texelFetch(depth, clamp(ivec2(x, y), ivec2(0), size - 1), 0).r; }

// Whether depth jumps from b to c of a, b, c, d in a row: x if c is nearer, y if b is.
uvec2 jumps(float a, float b, float c, float d) {
    float jump = c - b, before = b - a, after = d - c;
    return uvec2(jump > max(LEAST_JUMP * c, STEEPER * max(before, after)), -jump > max(LEAST_JUMP * b, -STEEPER * min(before, after)));
}

// Turns jumps between pixels and their neighbours into edges: x the neighbour is nearer, y the pixel is, z the waterline.
uvec3 edges_of(uvec2 jumps, uint sky, uint other_sky, uint sea, uint other_sea) {
    jumps &= ~(sky | other_sky | sea & other_sea);
    uint shore = (sea ^ other_sea) & ~(sky | other_sky | jumps.x | jumps.y);
    return uvec3(jumps.x | sky & ~other_sky, jumps.y | other_sky & ~sky, shore);
}

// A word of a plane and the bit after it, shifted to where the neighbour's right of each pixel stands.
uint right_of(int plane, int word, int row, uint own) {
    int words = words_of(size);
    uint next = word + 1 < words ? bits[word_index(size, plane, word + 1, row)] : 0u;
    return own >> 1 | next << 31;
}

void main() {
    ivec2 image = textureSize(depth, 0);
    size = seen_size(image, shading.size, shading.window.xy);
    int words = words_of(size), number = own_number();
    int word = number % words_of(image), top = number / words_of(image) * EDGE_ROWS, last = min(32, size.x - 32 * word);
    if (top >= size.y || word >= words) return;
    uint sky[EDGE_ROWS + 1], sea[EDGE_ROWS + 1], all_sky = ~0u, all_sea = ~0u;
    for (int r = 0; r <= EDGE_ROWS; ++r) {
        int row = min(top + r, size.y - 1);
        sky[r] = bits[word_index(size, SKY, word, row)];
        sea[r] = bits[word_index(size, SEA, word, row)];
        all_sky &= sky[r];
        all_sea &= sea[r];
    }
    uvec2 below[EDGE_ROWS], right[EDGE_ROWS];
    float before[EDGE_ROWS], here[EDGE_ROWS], after[EDGE_ROWS];
    for (int r = 0; r < EDGE_ROWS; ++r) below[r] = right[r] = uvec2(0u);
    // No turn where all is sky or sea: nor do software renderers run what conditions leave out.
    int first = all_sky == ~0u || all_sea == ~0u ? last : 0, left = 32 * word;
    for (bool any = first == 0; any; any = false) {
        for (int r = 0; r < EDGE_ROWS; ++r) {
            before[r] = depth_at(left - 1, top + r);
            here[r] = depth_at(left, top + r);
            after[r] = depth_at(left + 1, top + r);
        }
    }
    for (int k = first; k < last; ++k) {
        float column[EDGE_ROWS + 3];
        column[0] = depth_at(left + k, top - 1);
        for (int r = 0; r < EDGE_ROWS; ++r) column[r + 1] = here[r];
        column[EDGE_ROWS + 1] = depth_at(left + k, top + EDGE_ROWS);
        column[EDGE_ROWS + 2] = depth_at(left + k, top + EDGE_ROWS + 1);
        for (int r = 0; r < EDGE_ROWS; ++r) {
            float next = depth_at(left + k + 2, top + r);
            below[r] |= jumps(column[r], column[r + 1], column[r + 2], column[r + 3]) << k;
            right[r] |= jumps(before[r], here[r], after[r], next) << k;
            before[r] = here[r];
            here[r] = after[r];
            after[r] = next;
        }
    }
    // Pixels with a neighbour right of them.
    uint inner = last < 32 ? (1u << (last - 1)) - 1u : word + 1 < words ? ~0u : ~0u >> 1;
    for (int r = 0; r < EDGE_ROWS && top + r < size.y; ++r) {
        int row = top + r;
        uvec3 found = edges_of(below[r], sky[r], sky[r + 1], sea[r], sea[r + 1]);
        bits[word_index(size, BELOW_NEARER, word, row)] = found.x;
        bits[word_index(size, ABOVE_NEARER, word, row)] = found.y;
        bits[word_index(size, SHORE_BELOW, word, row)] = found.z;
        bits[word_index(size, ANY_BELOW, word, row)] = found.x | found.y | found.z;
        uint right_sky = right_of(SKY, word, row, sky[r]), right_sea = right_of(SEA, word, row, sea[r]);
        found = edges_of(right[r], sky[r], right_sky, sea[r], right_sea) & inner;
        bits[word_index(size, RIGHT_NEARER, word, row)] = found.x;
        bits[word_index(size, LEFT_NEARER, word, row)] = found.y;
        bits[word_index(size, SHORE_RIGHT, word, row)] = found.z;
        bits[word_index(size, ANY_RIGHT, word, row)] = found.x | found.y | found.z;
    }
}
