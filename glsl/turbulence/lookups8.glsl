// Turbulence by one fetch for each octave, all from one block of noise.
// Source: MJ 4.1 and Table 3 (8 noise lookups).
// p, width, enough and results: as octave_gradient.glsl has them.
// @exact procedural noise_block
// @loops 1
// @period memory
#define OCTAVE_MEAN MEANS_IN_BLOCKS.z
#include "octave_sum.glsl"
#include "noise_fetch.glsl"
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return fetched_noise(p); }
vec4 octave_gradient(vec3 p, int index) { return fetched_noise_gradient(p); }
