// A ray skips over the samples that the distance to the object shows to be empty, and lands on the same grid of samples:
// the picture does not change.
// Source: MJ 7 (empty-space skipping by the distance field).
// step_length: of one step, object space; result: whole steps to the next sample, at least 1.
#include "distance_bound.glsl"
float advance(float step_length) { return max(floor(distance_bound / step_length), 1.0); }
