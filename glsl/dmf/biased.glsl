// Bias: the density is pulled up or down, so that the object seems to swell or to shrink.
// Source: PH 2.3 (bias); position-independent: f(k).
// density: held in [0, 1]; result in [0, 1].
// @param density_bias = 0.5 in [0.01, 0.99]: Density that 0.5 becomes; 0.5 changes nothing.
#include "shaping.glsl"
float biased(float density, Sample s) { return bias(density_bias, density); }
