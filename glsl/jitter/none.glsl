// Every ray is sampled where the slices are.
// Source: -
// Result: phase of the samples of this pixel, in steps.
float sample_phase() { return 0.0; }
void shift_sample(inout vec3 eye, inout vec3 x) {}
