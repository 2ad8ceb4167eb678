// A plate of glass between z = 1/4 and z = -1/4, without end.
// Source: row P28 of the tests.
// x: object space.
#include "index_point.glsl"
Index index_at(vec3 x) { return abs(x.z) < 0.25 ? Index(1.5, 0.0, 1.0, 0.0) : Index(1.0, 0.0, 0.0, 0.0); }
vec3 pull(vec3 x, Index medium) { return vec3(0.0); }
vec3 interface_normal(vec3 from, vec3 to, out vec3 face) { return face = vec3(0.0, 0.0, 1.0); }
