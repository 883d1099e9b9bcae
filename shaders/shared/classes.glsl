// Classes of pixels by what they show, as depths that passes test against: see src/frame/classes.rs.

// Bits of a class: there are several surfaces; the sea lies in front of the ground; clouds may lie in front of both.
const int EDGE_BIT = 0;
const int SEA_BIT = 1;
const int CLOUDS_BIT = 2;

// Where classes of clouds begin.
const float CLOUDS_FROM = 3.5 / 8.0;

// A class as a depth: exact.
float class_depth(int code) { return float(code) / 8.0; }

// The class number `index` (0 to 3) of those that have a bit.
int class_with(int bit, int index) {
    int below = index & (1 << bit) - 1;
    return (index - below) << 1 | 1 << bit | below;
}
