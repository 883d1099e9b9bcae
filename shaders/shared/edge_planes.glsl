// Where neighbouring pixels show different surfaces: one bit a pixel and kind of edge, 32 pixels of a row a word. `edge_bits.comp` writes
// them, `edge_shares.comp` reads.

// Kinds: between a pixel and the one below it, or the one right of it; and which of the two is nearer.
const int BELOW_NEARER = 0;
const int ABOVE_NEARER = 1;
const int RIGHT_NEARER = 2;
const int LEFT_NEARER = 3;
// The waterline passes between a pixel and the one below it, or right of it: the surface is one, half of it under water.
const int SHORE_BELOW = 4;
const int SHORE_RIGHT = 5;
const int PLANES = 6;

int words_of(ivec2 size) { return (size.x + 31) / 32; }

// Where the word stands that holds pixel (32 word, row).
int word_index(ivec2 size, int plane, int word, int row) { return (plane * size.y + row) * words_of(size) + word; }
