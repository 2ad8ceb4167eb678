// The lattice of each octave: after how many of its cells it repeats.
// Source: MJ 4.1 (a block repeats, and every octave looks it up in its own scale).
// index: of the octave, from 0; result: one less than those cells, a power of two.
#include "lattice_noise.glsl"
uint octave_mask(int index) {
    int growing = index & (int(turbulence_cycle) - 1);          // of four octaves in one fetch, the fifth begins anew
    return (uint(turbulence_period) << (growing * int(turbulence_growth))) - 1u;
}
