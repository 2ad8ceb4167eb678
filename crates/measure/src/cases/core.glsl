// A red core.
// Source: -
// Result: linear RGB.
vec3 surface(Sample s) { return vec3(1.0, 0.0, 0.0); }
