// Turbulence computed in place: the very function that blocks hold samples of, without memory.
// Source: MJ 4.2 (computing noise in the shader), with an integer hash in place of the tables.
// p, width, enough and results: as octave_sum.glsl has them.
// @loops 1
#include "octave_sum.glsl"
#include "octave_lattice.glsl"
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return lattice_noise(p, octave_mask(index)); }
vec4 octave_gradient(vec3 p, int index) { return lattice_noise_gradient(p, octave_mask(index)); }
