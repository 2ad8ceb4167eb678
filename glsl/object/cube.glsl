// The cube [-1, 1]^3, exactly: no volume is needed.
// Source: PH 2.4 (base shapes).
// x: object space. The normal is that of the nearest face, edge or corner.
#include "surface_point.glsl"

Surface object(vec3 x) {
    vec3 q = abs(x) - 1.0;
    vec3 outside = max(q, 0.0);
    float inside = min(max(q.x, max(q.y, q.z)), 0.0);
    vec3 face = vec3(q.x >= q.y && q.x >= q.z, q.y > q.x && q.y >= q.z, q.z > q.x && q.z > q.y);
    return Surface(length(outside) + inside, sign(x) * (inside < 0.0 ? face : safe_normalize(outside, face)));
}
