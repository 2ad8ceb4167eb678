// The noise of one lattice cell, of the gradients at its eight corners.
// Source: PH 2.3: sum over the corners of weight times (gradient . offset); the derivative by the product rule.
// t: in [0, 1]^3; corners: x fastest, then y, then z; result: gradient per cell in xyz, noise in w.
#include <weights>
float between(float a, float b, float t) { return a + t * (b - a); }
vec3 between(vec3 a, vec3 b, float t) { return a + t * (b - a); }

vec4 noise_of_corners(vec3 t, vec3 g0, vec3 g1, vec3 g2, vec3 g3, vec3 g4, vec3 g5, vec3 g6, vec3 g7) {
    vec3 s = t - 1.0, w = fade(t), slope = fade_slope(t);
    float n0 = dot(g0, t), n1 = dot(g1, vec3(s.x, t.y, t.z)), n2 = dot(g2, vec3(t.x, s.y, t.z));
    float n3 = dot(g3, vec3(s.x, s.y, t.z)), n4 = dot(g4, vec3(t.x, t.y, s.z)), n5 = dot(g5, vec3(s.x, t.y, s.z));
    float n6 = dot(g6, vec3(t.x, s.y, s.z)), n7 = dot(g7, s);
    float y0 = between(n0, n1, w.x), y1 = between(n2, n3, w.x), y2 = between(n4, n5, w.x), y3 = between(n6, n7, w.x);
    float z0 = between(y0, y1, w.y), z1 = between(y2, y3, w.y);
    vec3 mean = between(between(between(g0, g1, w.x), between(g2, g3, w.x), w.y),
                        between(between(g4, g5, w.x), between(g6, g7, w.x), w.y), w.z);
    float across = between(between(n1 - n0, n3 - n2, w.y), between(n5 - n4, n7 - n6, w.y), w.z);
    return vec4(mean + slope * vec3(across, between(y1 - y0, y3 - y2, w.z), z1 - z0), between(z0, z1, w.z));
}
