// Turbulence by one fetch for each of the first four octaves; the others are left out.
// Source: MJ 4.1 and Table 3 (4 noise lookups).
// p, width, enough and results: as octave_gradient.glsl has them.
// @exact procedural noise_block
// @loops 1
// @period memory
// @octaves 4
#define OCTAVE_MEAN MEANS_IN_BLOCKS.z
#include "octave_sum.glsl"
#include "noise_fetch.glsl"
int octaves_held() { return min(OCTAVES, 4); }
float octave(vec3 p, int index) { return fetched_noise(p); }
vec4 octave_gradient(vec3 p, int index) { return fetched_noise_gradient(p); }
