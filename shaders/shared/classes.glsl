// Classes of pixels by what they show, as depths that passes test against: see src/frame/classes.rs.

// Twice these, plus 1 where there are several surfaces: where neither air nor sea nor clouds are; ground or sky with clear air before it;
// the sea. Where there may be clouds, too, it is CLASS_CLOUDY more.
const int CLASS_SPACE = 0;
const int CLASS_DRY = 1;
const int CLASS_SEA = 2;
const int CLASS_CLOUDY = 2;

// A class as a depth, and half-way to the next one, in exact steps.
float class_depth(int halves) { return float(halves) / 32.0; }
