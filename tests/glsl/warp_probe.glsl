// Where a warp moves p = (x, y, 0.37), and what its jacobian makes of v = (y, 1 - x, 0.5 + x y).
// Source: GLSL's own chain rule.
// Result: MODE 0: 0.5 + 0.1 displaced; 1: 0.5 + 0.02 jacobian * v; 2: how far points at 10 x move, in reaches.
#include "warp/MODULE.glsl"
vec3 surface(Sample s) {
    vec3 p = vec3(s.x.xy, 0.37);
    if (MODE == 2) p *= 10.0;
    vec3 moved = p;
    mat3 jacobian = mat3(1.0);
    MODULE(moved, jacobian);
    if (MODE == 0) return 0.5 + 0.1 * moved;
    if (MODE == 1) return 0.5 + 0.02 * (jacobian * vec3(p.y, 1.0 - p.x, 0.5 + p.x * p.y));
    return vec3(length(moved - p) / (REACH));
}
