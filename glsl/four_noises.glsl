// Four noises that do not know of each other: the channels of a block where it holds four, else at four places.
// Source: GG 39.5: the components of an RGBA texture of random numbers.
// p: lattice cells; result: each component as <noise>.
#include "vector_noise.glsl"
#ifndef FOUR_NOISES
vec4 four_noises(vec3 p) { return vec4(vector_noise(p), noise(p + 2.0 * NOISE_SHIFT)); }
#endif
