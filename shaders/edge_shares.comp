#version 460
// Edges at one sample a pixel, second half: how much of each pixel the other surface covers, from the shape of the edge: morphological
// anti-aliasing (Reshetov 2009). An edge between two rows (or columns) runs straight until it steps to the next one; where it steps the
// outline passes half a pixel beside it, so the outline is known along the whole run. An invocation writes 32 pixels of a row.
#include "layout.glsl"
#include "edges.glsl"
#include "edge_planes.glsl"
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 64) in;
layout(binding = 1) uniform sampler2D ground;
layout(scalar, binding = 3) readonly buffer EdgeBits { uint bits[]; };
// See edges.glsl; four pixels a word.
layout(scalar, binding = 4) buffer EdgeNotes { uint notes[]; };

ivec2 size;
int words;

uint word_at(int plane, int word, int row) { return bits[word_index(size, plane, word, row)]; }

bool bit_at(int plane, ivec2 pixel) { return (word_at(plane, pixel.x >> 5, pixel.y) >> (pixel.x & 31) & 1u) != 0u; }

// How many pixels of a row from this one on, itself included, have an edge of a kind; NO_END if nothing is seen to end it within reach.
const int NO_END = EDGE_REACH + 1;

int run_left(int plane, ivec2 pixel) {
    int word = pixel.x >> 5, count = (pixel.x & 31) + 1;
    uint gaps = ~word_at(plane, word, pixel.y) << (32 - count);
    if (gaps != 0u) return 31 - findMSB(gaps);
    while (--word >= 0 && count < NO_END) {
        gaps = ~word_at(plane, word, pixel.y);
        if (gaps != 0u) return min(count + 31 - findMSB(gaps), NO_END);
        count += 32;
    }
    return NO_END;
}

int run_right(int plane, ivec2 pixel) {
    int word = pixel.x >> 5, count = 32 - (pixel.x & 31);
    uint gaps = ~word_at(plane, word, pixel.y) >> (32 - count);
    if (gaps != 0u) count = findLSB(gaps);
    while (gaps == 0u && ++word < words && count < NO_END) {
        gaps = ~word_at(plane, word, pixel.y);
        count += gaps != 0u ? findLSB(gaps) : 32;
    }
    // Nothing is known of what lies right of the picture.
    return pixel.x + count < size.x ? min(count, NO_END) : NO_END;
}

// The same for a column, in steps of 1 or -1.
int run_down(int plane, ivec2 pixel, int by) {
    for (int count = 1; count < NO_END; ++count) {
        pixel.y += by;
        if (pixel.y < 0 || pixel.y >= size.y) return NO_END;
        if (!bit_at(plane, pixel)) return count;
    }
    return NO_END;
}

// Where an edge goes at the end of its run: -1 to the pixels before it (above or left), 1 to those after it, 0 to neither. `at` is the
// last pixel before the crossing edge's line, on the first side of the edge.
int turn(bool upright, int kind, bool at_end, ivec2 at) {
    ivec2 across = upright ? ivec2(1, 0) : ivec2(0, 1);
    // The crossing edge before the edge has the nearer surface beyond the run's end if the run's nearer one is after it.
    int crossing = upright ? BELOW_NEARER : RIGHT_NEARER;
    int outwards = at_end ? kind : 1 - kind;
    bool before = bit_at(crossing + outwards, at), after = bit_at(crossing + 1 - outwards, at + across);
    return int(after) - int(before);
}

// Integral from 0 to t of a line that falls from 1 to 0 at `reach`.
float under_line(float t, float reach) {
    t = min(t, reach);
    return t - 0.5 * t * t / reach;
}

// The same over the pixel that lies between t and t + 1, times a half: how far the outline is beside the edge there.
float part(int t, float reach) { return 0.5 * (under_line(float(t + 1), reach) - under_line(float(t), reach)); }

// Share of a pixel that the surface on the other side of an edge covers. `first` is the pixel before the edge (above or left of it);
// `side` is 1 if the pixel asked for is that one, -1 if it is the other.
float share_beside(bool upright, int kind, ivec2 first, int side) {
    int plane = (upright ? RIGHT_NEARER : BELOW_NEARER) + kind;
    int back = upright ? run_down(plane, first, -1) : run_left(plane, first);
    int on = upright ? run_down(plane, first, 1) : run_right(plane, first);
    ivec2 along = upright ? ivec2(0, 1) : ivec2(1, 0);
    bool ends_back = back < NO_END, ends_on = on < NO_END;
    // Which side the outline goes to at either end.
    int turn_back = ends_back ? turn(upright, kind, false, first - back * along) : 0;
    int turn_on = ends_on ? turn(upright, kind, true, first + (on - 1) * along) : 0;
    float run = float(back + on - 1), reach = float(EDGE_REACH);
    // It meets the edge half-way between two turns, or at an end without a turn.
    if (ends_back && ends_on) reach = turn_back != 0 && turn_on != 0 ? 0.5 * run : run;
    float share = 0.0;
    if (turn_back == -side) share += part(back - 1, reach);
    if (turn_on == -side) share += part(on - 1, reach);
    return share;
}

// Kind of the edge between a pixel and the next: 0 if the next is nearer, 1 if the pixel is; -1 without one.
int kind_of(bool upright, ivec2 first) {
    if (any(lessThan(first, ivec2(0)))) return -1;
    int plane = upright ? RIGHT_NEARER : BELOW_NEARER;
    return bit_at(plane, first) ? 0 : bit_at(plane + 1, first) ? 1 : -1;
}

// Share of the other side of the waterline: it passes where the height above the sea, linear between pixels, is 0.
float share_of_shore(ivec2 pixel, ivec2 other) {
    float own = abs(texelFetch(ground, pixel, 0).a), others = abs(texelFetch(ground, other, 0).a);
    return max(0.5 - own / max(own + others, 1e-9), 0.0);
}

uint note_of(ivec2 pixel) {
    float best = 0.0;
    int chosen = 0, nearer = 0, farther = 0, open = 0;
    for (int k = 0; k < 4; ++k) {
        bool upright = k < 2;
        ivec2 other = pixel + NEIGHBOURS[k], first = min(pixel, other);
        int kind = kind_of(upright, first), side = (k & 1) == 0 ? 1 : -1;
        bool shore = all(greaterThanEqual(first, ivec2(0))) && bit_at(upright ? SHORE_RIGHT : SHORE_BELOW, first);
        float share = shore ? share_of_shore(pixel, other) : 0.0;
        if (kind < 0) open = k;
        else if ((kind == 0) == (side == 1)) ++nearer;
        else ++farther;
        for (bool edge = kind >= 0; edge; edge = false) share = share_beside(upright, kind, first, side);
        if (share > best) {
            best = share;
            chosen = k;
        }
    }
    // One pixel of a surface alone is narrower than it looks.
    if (max(nearer, farther) >= 3) {
        best = 0.5;
        chosen = max(nearer, farther) == 4 ? 3 : open ^ 1;
    }
    return edge_code(int(best * float(SHARE_PARTS) + 0.5), chosen);
}

void main() {
    size = textureSize(ground, 0);
    words = words_of(size);
    int number = int(gl_GlobalInvocationID.x), word = number % words, row = number / words;
    if (row >= size.y) return;
    for (int k = 0; k < 8; ++k) notes[8 * number + k] = 0u;
    uint beside = word_at(RIGHT_NEARER, word, row) | word_at(LEFT_NEARER, word, row) | word_at(SHORE_RIGHT, word, row);
    uint edges = beside | beside << 1 | word_at(BELOW_NEARER, word, row) | word_at(ABOVE_NEARER, word, row) | word_at(SHORE_BELOW, word, row);
    if (word > 0) {
        uint left = word_at(RIGHT_NEARER, word - 1, row) | word_at(LEFT_NEARER, word - 1, row) | word_at(SHORE_RIGHT, word - 1, row);
        edges |= left >> 31;
    }
    if (row > 0) edges |= word_at(BELOW_NEARER, word, row - 1) | word_at(ABOVE_NEARER, word, row - 1) | word_at(SHORE_BELOW, word, row - 1);
    if (32 * word + 32 > size.x) edges &= (1u << (size.x & 31)) - 1u;
    for (; edges != 0u; edges &= edges - 1u) {
        int k = findLSB(edges);
        notes[8 * number + k / 4] |= note_of(ivec2(32 * word + k, row)) << (8 * (k & 3));
    }
}
