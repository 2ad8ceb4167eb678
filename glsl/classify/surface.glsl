// A hard object: the iso-surface alone.
// Source: MJ 3.5.
// x: object space; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
#include "sample.glsl"
#include <surface>

vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    return s.density <= 0.0 ? vec4(0.0) : vec4(surface(s), 1.0);
}
