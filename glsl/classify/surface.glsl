// A hard object: the iso-surface alone, located between the first sample behind it and the one before.
// Source: MJ 3.5; where it is within the step is ours.
// x: object space; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
// @outside empty
// @segments surface_segment
#include "sample.glsl"
#include "distance_bound.glsl"
#include "located.glsl"
#include <surface>
#include "two_phases.glsl"

Sample look(vec3 x) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    return s;
}

vec4 matter(Sample s, float path, bool hard) {
    if (!hard) return vec4(0.0);
    locate(s, outer_iso_value, path);
    s.normal = cap_normal(s.x, s.normal);
    return vec4(surface(s), 1.0);
}
