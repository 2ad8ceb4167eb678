// Debug look: gradient normals as colors.
// Source: MJ 3.1, Fig. 3a.
// Result: linear RGB.
// @needs normal
vec3 surface(Sample s) { return 0.5 + 0.5 * s.normal; }
