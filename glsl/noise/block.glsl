// Noise by one fetch from the precomputed block, repeated without end.
// Source: MJ 4.1.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 1.
// @exact procedural noise_block
// @loops 1
// @period memory
#include "noise_fetch.glsl"
#define NOISE_MEAN MEANS_IN_BLOCKS.z
vec4 noise_gradient(vec3 p) { return fetched_noise_gradient(p); }
float noise(vec3 p) { return fetched_noise(p); }
