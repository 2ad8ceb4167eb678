// Debug look: the proxy slices themselves, and where they cut the object.
// Source: MJ 2, Fig. 1.
// x: object space; path: object units, unused; result premultiplied linear RGBA.
#include "sample.glsl"
#include "distance_bound.glsl"
#include <surface>

vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    return s.density > 0.0 ? vec4(color.rgb * surface(s), 1.0) : vec4(color.rgb * 0.05, 0.05);
}
