// Maxwell's fish-eye of radius 1: rays run in circles, and leave opposite to their entry.
// Source: n = 2 / (1 + r^2).
// x: object space.
#include "index_point.glsl"
Index index_at(vec3 x) {
    float r2 = dot(x, x);
    return r2 < 1.0 ? Index(2.0 / (1.0 + r2), 1.0, 1.0, 0.0) : Index(1.0, 0.0, 0.0, 0.0);
}
vec3 pull(vec3 x, Index medium) {
    float u = 1.0 + dot(x, x);
    return -8.0 * x / (u * u * u);
}
vec3 interface_normal(vec3 from, vec3 to, out vec3 face) { return face = from; }
