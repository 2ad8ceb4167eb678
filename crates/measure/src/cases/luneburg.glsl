// The Luneburg lens of radius 1: parallel rays meet at its far side.
// Source: n = sqrt(2 - r^2).
// x: object space.
#include "index_point.glsl"
Index index_at(vec3 x) {
    float r2 = dot(x, x);
    return r2 < 1.0 ? Index(sqrt(2.0 - r2), 1.0, 1.0, 0.0) : Index(1.0, 0.0, 0.0, 0.0);
}
vec3 pull(vec3 x, Index medium) { return -x; }
vec3 interface_normal(vec3 from, vec3 to, out vec3 face) { return face = from; }
