// Noise computed in place from an integer hash: no memory, and no period below 2^20 cells unless one is asked for.
// Source: PH 2.3, MJ 4.2.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.87.
// @loops 1
#include "lattice_noise.glsl"
#define NOISE_MEAN MEAN_OF_GRADIENTS
uint noise_mask() { return uint(noise_period) - 1u; }
vec4 noise_gradient(vec3 p) { return lattice_noise_gradient(p, noise_mask()); }
float noise(vec3 p) { return lattice_noise(p, noise_mask()); }
