// Included by ballot.comp.
bool is_odd(uint value) { return (value & 1u) == 1u; }
