// Soft matter colored by its density through the transfer map.
// Source: PH 2.4 (low density red, high yellow), MJ 6 (transfer functions as textures).
// density: modulated, in [0, 1]; result: linear RGB.
#include <transfer>
vec3 medium(Sample s, float density) { return transfer(density).rgb; }
