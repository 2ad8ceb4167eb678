// The torus with radii 0.7 and 0.3 around the y axis, exactly: no volume is needed.
// Source: PH 2.4 (base shapes).
// x: object space.
#include "surface_point.glsl"
const float MAJOR_RADIUS = 0.7;
const float MINOR_RADIUS = 0.3;

Surface object(vec3 x) {
    vec3 ring = safe_normalize(vec3(x.x, 0.0, x.z), vec3(1.0, 0.0, 0.0)) * MAJOR_RADIUS;
    vec3 from_ring = x - ring;
    return Surface(length(from_ring) - MINOR_RADIUS, safe_normalize(from_ring, vec3(0.0)));
}
