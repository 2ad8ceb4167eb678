// Turbulence summed octave by octave from slot <noise>, whatever fills it.
// Source: PH 2.3, MJ Eq. 4; with noise = wavelet the footnote of PH 2.3.
// p, width, enough and results: as octave_gradient.glsl has them.
#include <noise>
#ifdef NOISE_MEAN
#define OCTAVE_MEAN NOISE_MEAN
#endif
#include "octave_sum.glsl"
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return noise(p); }
vec4 octave_gradient(vec3 p, int index) { return noise_gradient(p); }
