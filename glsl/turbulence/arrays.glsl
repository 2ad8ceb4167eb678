// Turbulence of Perlin's tables of 1989, in constant arrays: impossible in 2005.
// Source: MJ 4.2.
// p, width, enough and results: as octave_gradient.glsl has them.
// @loops 1
// @period memory
#include "octave_sum.glsl"
#include "array_noise.glsl"
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return array_noise(p).w; }
vec4 octave_gradient(vec3 p, int index) { return array_noise(p); }
