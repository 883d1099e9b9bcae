#version 460
// Edges at one sample a pixel, second half: how much of each pixel the other surface covers, from the shape of the edge: morphological
// anti-aliasing (Reshetov 2009). An edge between two rows (or columns) runs straight until it steps to the next one; where it steps the
// outline passes half a pixel beside it, so the outline is known along the whole run. An invocation writes 32 pixels of a row.
#include "shading.glsl"
#include "edges.glsl"
#include "edge_planes.glsl"

layout(binding = 1) uniform sampler2D ground;
layout(scalar, binding = 3) readonly buffer EdgeBits { uint bits[]; };
// See edges.glsl; four pixels a word.
layout(scalar, binding = 4) buffer EdgeNotes { uint notes[]; };

ivec2 size;
int words;

uint word_at(int plane, int word, int row) { return bits[word_index(size, plane, word, row)]; }

bool bit_at(int plane, ivec2 pixel) { return (word_at(plane, pixel.x >> 5, pixel.y) >> (pixel.x & 31) & 1u) != 0u; }

// How many pixels from this one on, itself included, have an edge of a kind, as far as the picture goes; NO_END if they are more than
// EDGE_REACH. Nothing farther away counts, so that parts of a picture have the edges of the whole.
const int NO_END = EDGE_REACH + 1;

int run_left(int plane, ivec2 pixel) {
    int word = pixel.x >> 5, count = (pixel.x & 31) + 1;
    uint gaps = ~word_at(plane, word, pixel.y) << (32 - count);
    if (gaps != 0u) return 31 - findMSB(gaps);
    while (gaps == 0u && --word >= 0 && count < NO_END) {
        gaps = ~word_at(plane, word, pixel.y);
        count += gaps != 0u ? 31 - findMSB(gaps) : 32;
    }
    return min(count, NO_END);
}

int run_right(int plane, ivec2 pixel) {
    int word = pixel.x >> 5, count = 32 - (pixel.x & 31);
    uint gaps = ~word_at(plane, word, pixel.y) >> (32 - count);
    if (gaps != 0u) count = findLSB(gaps);
    while (gaps == 0u && ++word < words && count < NO_END) {
        gaps = ~word_at(plane, word, pixel.y);
        count += gaps != 0u ? findLSB(gaps) : 32;
    }
    return min(min(count, size.x - pixel.x), NO_END);
}

// The same for a column, in steps of 1 or -1.
int run_along(int plane, ivec2 pixel, int by) {
    int count = 1, most = min(by < 0 ? pixel.y + 1 : size.y - pixel.y, NO_END);
    while (count < most && bit_at(plane, ivec2(pixel.x, pixel.y + by * count))) ++count;
    return count;
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
    int back = upright ? run_along(plane, first, -1) : run_left(plane, first);
    int on = upright ? run_along(plane, first, 1) : run_right(plane, first);
    ivec2 along = upright ? ivec2(0, 1) : ivec2(1, 0);
    ivec2 before = first - back * along, last = first + (on - 1) * along;
    // Which side the outline goes to at either end; where the picture ends or the run is too long, nobody knows.
    bool ends_back = back < NO_END && min(before.x, before.y) >= 0;
    bool ends_on = on < NO_END && all(lessThan(last + along, size));
    int turn_back = ends_back ? turn(upright, kind, false, before) : 0;
    int turn_on = ends_on ? turn(upright, kind, true, last) : 0;
    // It meets the edge half-way between two turns, or at the other end, as far as that is known.
    float run = float(back + on - 1);
    float reach = turn_back != 0 && turn_on != 0 ? 0.5 * run : ends_back && ends_on ? run : min(run, float(EDGE_REACH));
    float share = 0.0;
    if (turn_back == -side) share += part(back - 1, reach);
    if (turn_on == -side) share += part(on - 1, reach);
    return share;
}

float height_at(ivec2 pixel) { return texelFetch(ground, clamp(pixel, ivec2(0), size - 1), 0).a; }

// Share of the other side of the waterline, where the height above the sea is 0, from that height and its changes along x and y; and the
// neighbour where the other side is widest. Neighbours that are `apart` are on another surface.
float share_of_shore(ivec2 pixel, bvec4 apart, out int chosen) {
    float own = height_at(pixel), widest = -1.0;
    vec2 change = vec2(0.0), count = vec2(0.0);
    chosen = 0;
    for (int k = 0; k < 4; ++k) {
        float other = height_at(pixel + NEIGHBOURS[k]);
        float weight = apart[k] ? 0.0 : 1.0;
        change[k / 2] += weight * abs(other - own);
        count[k / 2] += weight;
        if (!apart[k] && (own < 0.0) != (other < 0.0) && abs(other) > widest) {
            widest = abs(other);
            chosen = k;
        }
    }
    change /= max(count, 1.0);
    // Of a pixel cut by a straight line: a triangle or, if that reaches both corners, a trapezium.
    float more = max(max(change.x, change.y), 1e-9), less = min(change.x, change.y), corner = 0.5 * (more + less) - abs(own);
    return corner <= less ? max(corner, 0.0) * max(corner, 0.0) / (2.0 * more * max(less, 1e-9)) : 0.5 - abs(own) / more;
}

// The words of the edges between the pixels of a word and their neighbours on one side: x where the one below or right is nearer, y
// where the one above or left is, z the waterline.
uvec3 edges_towards(int k, int word, int row) {
    int plane = k < 2 ? RIGHT_NEARER : BELOW_NEARER, shore = k < 2 ? SHORE_RIGHT : SHORE_BELOW;
    if (k == 3) --row;
    if (row < 0) return uvec3(0u);
    uvec3 own = uvec3(word_at(plane, word, row), word_at(plane + 1, word, row), word_at(shore, word, row));
    if (k != 1) return own;
    uvec3 left = word == 0 ? uvec3(0u) : uvec3(word_at(plane, word - 1, row), word_at(plane + 1, word - 1, row), word_at(shore, word - 1, row));
    return own << 1 | left >> 31;
}

uint note_of(ivec2 pixel, uvec3 edges[4]) {
    float best = 0.0;
    int chosen = 0, nearer = 0, farther = 0, open = 0;
    bvec4 apart = bvec4(false);
    uint shore = 0u;
    for (int k = 0; k < 4; ++k) {
        uvec3 edge = edges[k] >> (pixel.x & 31) & 1u;
        int kind = int(edge.y), side = (k & 1) == 0 ? 1 : -1;
        ivec2 other = pixel + NEIGHBOURS[k];
        float share = 0.0;
        shore |= edge.z;
        apart[k] = (edge.x | edge.y) != 0u;
        if (!apart[k]) open = k;
        else if ((kind == 0) == (side == 1)) ++nearer;
        else ++farther;
        // A loop of one turn.
        for (bool on = apart[k]; on; on = false) share = share_beside(k < 2, kind, min(pixel, other), side);
        if (share > best) {
            best = share;
            chosen = k;
        }
    }
    for (; shore != 0u; shore = 0u) {
        int other;
        float share = share_of_shore(pixel, apart, other);
        if (share > best) {
            best = share;
            chosen = other;
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
    ivec2 image = textureSize(ground, 0);
    size = seen_size(image, shading.size, shading.window.xy);
    words = words_of(size);
    int number = own_number(), word = number % words_of(image), row = number / words_of(image);
    if (row >= size.y || word >= words) return;
    uint beside = word_at(ANY_RIGHT, word, row);
    uint left = word > 0 ? word_at(ANY_RIGHT, word - 1, row) >> 31 : 0u;
    uint above = row > 0 ? word_at(ANY_BELOW, word, row - 1) : 0u;
    uint left_to_do = beside | beside << 1 | left | above | word_at(ANY_BELOW, word, row);
    if (32 * word + 32 > size.x) left_to_do &= (1u << (size.x & 31)) - 1u;
    // A loop of one turn: software renderers run the bodies of all conditions.
    for (bool any = left_to_do != 0u; any; any = false) {
        uvec3 edges[4];
        for (int k = 0; k < 4; ++k) edges[k] = edges_towards(k, word, row);
        for (; left_to_do != 0u; left_to_do &= left_to_do - 1u) {
            int k = findLSB(left_to_do);
            notes[8 * number + k / 4] |= note_of(ivec2(32 * word + k, row), edges) << (8 * (k & 3));
        }
    }
}
