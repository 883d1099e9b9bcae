// What neighbouring pixels show, and where they show different surfaces: one bit a pixel and plane, 32 pixels of a row a word.
// `edge_kinds.comp` writes what pixels show, `edge_bits.comp` the others, and `edge_shares.comp` reads them.

// Edges between a pixel and the one below it, or the one right of it, by which of the two is nearer.
const int BELOW_NEARER = 0;
const int ABOVE_NEARER = 1;
const int RIGHT_NEARER = 2;
const int LEFT_NEARER = 3;
// The waterline passes between a pixel and the one below it, or right of it: the surface is one, half of it under water.
const int SHORE_BELOW = 4;
const int SHORE_RIGHT = 5;
// Pixels that show the sky, and the sea.
const int SKY = 6;
const int SEA = 7;

// Pixels with any edge below them, and right of them.
const int ANY_BELOW = 8;
const int ANY_RIGHT = 9;

// The part of an image that lies in the picture: the last windows of a picture reach beyond it.
ivec2 seen_size(ivec2 image, vec2 picture, vec2 origin) { return min(image, ivec2(picture - origin)); }

int words_of(ivec2 size) { return (size.x + 31) / 32; }

// Where the word stands that holds pixel (32 word, row).
int word_index(ivec2 size, int plane, int word, int row) { return (plane * size.y + row) * words_of(size) + word; }

// Number of the words that an invocation looks at. Eight are neighbours; the next eight are elsewhere, in another SPREADth of the picture:
// skies cost nothing and skylines much, and software renderers give each thread one run of workgroups.
layout(local_size_x = 64) in;
const uint SPREAD = 16u;
int own_number() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint eights = gl_WorkGroupSize.x / 8u, length = max(groups * eights / SPREAD, 1u);
    uint eight = group * eights + gl_LocalInvocationID.x / 8u;
    // What does not divide comes last.
    if (eight < SPREAD * length && groups * eights >= SPREAD) eight = eight % length * SPREAD + eight / length;
    return int(eight * 8u + gl_LocalInvocationID.x % 8u);
}
