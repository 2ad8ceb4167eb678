// A hard object: the iso-surface alone, located between a sample and the one before, also where both are outside.
// Source: MJ 3.5; where it is within the step is ours.
// x: object space; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
// @outside empty
// @segments surface_segment
// @looks back
#include "sample.glsl"
#include "distance_bound.glsl"
#include "located.glsl"
#include <surface>
#include "two_phases.glsl"

float begins_at = 0.0;      // how far before the sample the surface is, in steps

// Density 1: the surface may be at the sample or in the step before it.
Sample look(vec3 x) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    s.density = may_begin(s.distance - iso_value, sample_reach) ? 1.0 : 0.0;
    return s;
}

bool begins(vec3 x, float path) { return meets(x, distance_found - iso_value, iso_value, path, begins_at); }

vec4 matter(Sample s, float path, bool hard) {
    if (!hard) return vec4(0.0);
    s = moved_back(s, begins_at, path);
    s.normal = cap_normal(s.x, s.normal);
    return vec4(surface(s), 1.0);
}
