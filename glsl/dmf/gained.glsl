// Gain: the soft region becomes steeper or flatter in its middle, so that the object seems sharper or softer.
// Source: PH 2.3 (gain); position-independent: f(k).
// density: held in [0, 1]; result in [0, 1].
// @param density_gain = 0.5 in [0.01, 0.99]: Steepness of the middle of the soft region; 0.5 changes nothing.
#include "shaping.glsl"
float gained(float density, Sample s) { return gain(density_gain, density); }
