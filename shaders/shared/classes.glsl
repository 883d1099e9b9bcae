// Classes of pixels by what they show, as depths that passes test against: see src/frame/classes.rs.

// Bits of a class: the sea lies in front of the ground; clouds may lie in front of both; there are several surfaces.
const int SEA_BIT = 0;
const int CLOUDS_BIT = 1;
const int EDGE_BIT = 2;

// A class as a depth: exact, and as far from the next one as can be.
float class_depth(int code) { return float(code) / 8.0; }

// The class number `index` (0 to 3) of those that have a bit set, or do not.
int class_with(int bit, int value, int index) {
    int below = index & (1 << bit) - 1;
    return (index - below) << 1 | value << bit | below;
}
