// Post-classification: the density is interpolated, then looked up in the transfer map.
// Source: MJ 2.
// x: object space; path: object units; result premultiplied linear RGBA.
// @outside transfer
#include "sample.glsl"
#include "distance_bound.glsl"
#include <transfer>
#include <dmf>
#include <opacity>

vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    vec4 matter = transfer(clamp(modulate(s.density, s), 0.0, 1.0));
    float alpha = opacity(matter.a, opacity_rate * path);
    return vec4(matter.rgb * alpha, alpha);
}
