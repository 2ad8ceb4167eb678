// A hard object: the iso-surface alone, found where it lies within the step, also where both of its ends are outside.
// Source: MJ 3.5; where it is within the step is ours: see step_back.glsl. The first slice behind the surface has the step.
// x: object space, middle of the step; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
#include "sample.glsl"
#include "segment.glsl"
#include "distance_bound.glsl"
#include "located.glsl"
#include <surface>

vec4 classify(vec3 x, float path) {
    vec3 end = x + 0.5 * to_far_end(path);
    Sample s = sample_object(end);
    float gap = s.distance - iso_value, at = 0.0;
    distance_bound = s.distance_bound;
    if (!may_begin(gap, 2.0 * sample_reach) || !meets(end, gap, iso_value, path, at)) return vec4(0.0);
    if (gap < 0.0 && at <= 0.0) at = 1.0;       // the ray was inside before
    position_eye -= to_eye() * (0.5 * path);
    s = moved_back(s, at, path);
    s.normal = cap_normal(s.x, s.normal);
    return vec4(surface(s), 1.0);
}
