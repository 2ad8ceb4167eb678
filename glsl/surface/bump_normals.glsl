// Debug look: the normals of bump mapping as colors.
// Source: MJ 5.2, Eq. 7.
// Result: linear RGB, 0.5 + 0.5 n.
#include "bump_normal.glsl"
vec3 surface(Sample s) { return 0.5 + 0.5 * bump_normal(s); }
