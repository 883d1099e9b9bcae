// Codings that Rust writes and shaders read. Twins: planet/src/draw/layout/mod.rs (pairs), planet/src/mesh/wake.rs (wakes),
// planet/src/ground/texture.rs (heights above the sea).

#ifndef TERRANE_CODINGS
#define TERRANE_CODINGS
#include "layout.glsl"

// Two 16-bit numbers in a word.
uint low16(uint pair) { return pair & 0xffffu; }
uint high16(uint pair) { return pair >> 16u; }

// The distance that a wake's 16 bits stand for: exponent and mantissa, exact in single precision.
float wake_distance(uint code) { return uintBitsToFloat((code << (23u - WAKE_MANTISSA_BITS)) + floatBitsToUint(1.0)); }

// Height above the sea in metres from what the texture holds, 0 to 1.
float decode_shore(float stored) {
    float shore = 2.0 * stored - 1.0;
    return sign(shore) * shore * shore * SHORE_RANGE;
}

#endif
