// A hard object: the iso-surface alone, found where it lies within the step.
// Source: MJ 3.5; ours: the crossing of a line through the distances at both ends of the step, and again through the
// distance found there. An error of the third order in the step; the first slice behind the surface has the step.
// x: object space, middle of the step; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
#include "sample.glsl"
#include "segment.glsl"
#include "distance_bound.glsl"
#include <surface>

float far_gap = 0.0;        // distance to the surface at the end of the step before, along a ray

float gap_at(vec3 x) { return sample_object(x).distance - outer_iso_value; }

vec4 classify(vec3 x, float path) {
    vec3 along = to_far_end(path), from = x - 0.5 * along;
    float near = far_gap;
    if (!follows) near = gap_at(from);
    float far = gap_at(from + along);
    far_gap = far;
    distance_bound = far - skip_slack;
    vec2 part = kept(from, along);
    if (part.x > part.y) return vec4(0.0);
#ifndef UNCUT
    if (part.x > 0.0) near = gap_at(from + part.x * along);
    if (part.y < 1.0) far = gap_at(from + part.y * along);
#endif
    if (near > 0.0 && far > 0.0) return vec4(0.0);
    float t = part.x;
    Sample s;
    if (near > 0.0) {
        t = mix(part.x, part.y, place_of(0.0, near, far));
        float gap = gap_at(from + t * along);
        t = gap > 0.0 ? mix(t, part.y, place_of(0.0, gap, far)) : mix(part.x, t, place_of(0.0, near, gap));
    }
    look_from_middle_to(t, path);
    s = sample_object(from + t * along);
    s.normal = cap_normal(s.x, s.normal);
    return vec4(surface(s), 1.0);
}
