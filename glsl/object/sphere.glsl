// The unit sphere, exactly: no volume is needed.
// Source: MJ Eq. 1, PH 2.1.
// x: object space.
#include "surface_point.glsl"

Surface object(vec3 x) { return Surface(length(x) - 1.0, safe_normalize(x, vec3(0.0))); }
