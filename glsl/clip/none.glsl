// No clipping plane.
// Source: -
// x: object space. UNCUT: all of every segment is left, and nobody has to ask.
#define UNCUT
bool clipped(vec3 x) { return false; }
vec2 kept(vec3 from, vec3 along) { return vec2(0.0, 1.0); }
vec3 cap_normal(vec3 x, vec3 normal) { return normal; }
