// A hard object: the iso-surface alone.
// Source: MJ 3.5.
// x: object space; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
#include "sample.glsl"
#include <surface>

vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    if (s.density <= 0.0) return vec4(0.0);
    s.normal = cap_normal(x, s.normal);
    return vec4(surface(s), 1.0);
}
