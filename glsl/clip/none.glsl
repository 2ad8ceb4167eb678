// No clipping plane.
// Source: -
// x: object space.
bool clipped(vec3 x) { return false; }
vec3 cap_normal(vec3 x, vec3 normal) { return normal; }
