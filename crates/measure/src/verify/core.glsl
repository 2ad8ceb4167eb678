// A red core.
// Source: truth 5, which is a sum of two tones.
// Result: linear RGB.
vec3 surface(Sample s) { return vec3(1.0, 0.0, 0.0); }
