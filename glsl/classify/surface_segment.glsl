// A hard object: the iso-surface alone, found where it lies within the step.
// Source: MJ 3.5; ours: the crossing of a line through the distances at both ends of the step, and again through the
// distance found there. An error of the third order in the step; the first slice behind the surface has the step.
// x: object space, middle of the step; path: object units; result premultiplied linear RGBA, alpha 0 or 1.
#include "sample.glsl"
#include "segment.glsl"
#include "distance_bound.glsl"
#include <surface>

float far_gap = 0.0;        // distance to the surface at the end of the step before, along a ray
float far_part = 0.0;       // how much of that step was left by what cuts it: 1 where it ends where this one begins

// The places of a segment that are looked at: its ends, where a line crosses the surface, and where that is shaded.
const int NEAR = 0, FAR = 1, CROSSING = 2, SHADED = 3;

vec4 classify(vec3 x, float path) {
    vec3 along = to_far_end(path), from = x - 0.5 * along;
    vec2 part = kept(from, along);
    float near = far_gap, far = 0.0, t = part.x;
    bool found = false;
    Sample s;
    // As in soft_segment.glsl: a program holds the object once, and a device that runs both sides of a branch leaves a loop.
    int first = follows && far_part >= 1.0 && part.x <= 0.0 ? FAR : NEAR;
    for (int place = first; place <= (found ? SHADED : FAR); ++place) {
        if (place == CROSSING && near <= 0.0) place = SHADED;
        if (place == CROSSING) t = mix(part.x, part.y, place_of(0.0, near, far));
        s = sample_object(from + (place == FAR ? part.y : t) * along);
        float gap = s.distance - outer_iso_value;
        if (place == NEAR) near = gap;
        if (place == FAR) {
            far = gap;
            distance_bound = part.y < 1.0 ? 0.0 : far - skip_slack;
            found = part.x <= part.y && (near <= 0.0 || far <= 0.0);
        }
        if (place == CROSSING) {
            t = gap > 0.0 ? mix(t, part.y, place_of(0.0, gap, far)) : mix(part.x, t, place_of(0.0, near, gap));
        }
    }
    far_gap = far;
    far_part = part.y;
    if (!found) return vec4(0.0);
    look_from_middle_to(t, path);
    s.normal = cap_normal(s.x, s.normal);
    return vec4(surface(s), 1.0);
}
