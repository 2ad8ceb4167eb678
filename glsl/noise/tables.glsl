// Noise of Perlin's tables of 1989, in images of one row.
// Source: PH 2.3, MJ 4.2.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.87.
// @exact arrays
// @loops 1
// @period memory
#include "table_noise.glsl"
#define NOISE_MEAN MEAN_OF_GRADIENTS
vec4 noise_gradient(vec3 p) { return table_noise(p); }
float noise(vec3 p) { return table_noise(p).w; }
