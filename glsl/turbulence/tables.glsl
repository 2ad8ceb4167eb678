// Turbulence of Perlin's tables of 1989, in images of one row: 11 fetches for each octave.
// Source: MJ 4.2.
// p, width, enough and results: as octave_gradient.glsl has them.
// @exact arrays
// @loops 1
// @period memory
#include "octave_sum.glsl"
#include "table_noise.glsl"
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return table_noise(p).w; }
vec4 octave_gradient(vec3 p, int index) { return table_noise(p); }
