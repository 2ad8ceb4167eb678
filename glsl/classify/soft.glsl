// A hypertextured object: the surface in the hard region, the modulated density around it.
// Source: MJ 6; the opacity is PH 3.1, and so is that a gradient is asked for only where 0 < density < 1. Where the hard
// region begins within the step is ours.
// x: object space; path: object units; result premultiplied linear RGBA.
// @outside empty
// @segments soft_segment
#include "sample.glsl"
#include "distance_bound.glsl"
#include "located.glsl"
#include <dmf>
#include <opacity>
#include <gradient>
#include <surface>
#include <medium>
#include "two_phases.glsl"

Sample look(vec3 x) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    if (s.density <= 0.0) remember(0.0);                    // MJ 6: outside the soft region
    return s;
}

bool begins(vec3 x, float path) { return true; }

vec4 matter(Sample s, float path, bool hard) {
    float own = clamp(modulate(s.density, s), 0.0, 1.0), density = own;
    if (own <= 0.0) {
        remember(0.0);
        return vec4(0.0);
    }
    if (hard) {
        remember(own);
        float at = 0.0;
        meets(s.x, s.distance - iso_value, iso_value, path, at);
        s = moved_back(s, at, path);
        s.normal = cap_normal(s.x, s.normal);
        float alpha = opacity(own, opacity_rate * path);
        return vec4(surface(s) * alpha, alpha);
    }
    float alpha = opacity(own, opacity_rate * extinction(s, own) * path);
    enter(s, density, path);
    if (density < 1.0) s.shading = shading_normal(s, density, path);
    remember(own);
    return vec4(medium(s, density) * alpha, alpha);
}
