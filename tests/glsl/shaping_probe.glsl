// Bias and gain of the place on a face: t = 0.5 + 0.5 x, b = g = 0.5 + 0.5 y.
// Source: PH 2.3.
// Result: bias, gain, t.
#include "shaping.glsl"
vec3 surface(Sample s) {
    vec2 p = 0.5 + 0.5 * s.x.xy;
    return vec3(bias(p.y, p.x), gain(p.y, p.x), p.x);
}
