// Debug look: the normals of bump mapping as colors, brought back to object space, so that they turn with the object.
// Source: MJ 5.2, Eq. 7; the way back is ours.
// Result: linear RGB, 0.5 + 0.5 n.
#include "bump_normal.glsl"
vec3 surface(Sample s) { return 0.5 + 0.5 * safe_normalize(inverse(mat3(normal_matrix)) * bump_normal(s), s.normal); }
