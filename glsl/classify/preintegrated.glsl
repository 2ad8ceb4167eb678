// Pre-integrated classification: the transfer map integrated over the segment between the densities at its two ends.
// Source: Engel, Kraus and Ertl 2001 (cited by MJ 2); GG 39.6.1.
// x: object space, middle of the segment; path: object units; result premultiplied linear RGBA.
// The table holds the segment of one slice spacing; a longer path under perspective scales its optical depth.
// @groom length color
// @outside transfer
// @segments preintegrated
#include "sample.glsl"
#include "distance_bound.glsl"
#include <dmf>
#include <filter>
#include <opacity>            // of the entries of the table: opacity_table.frag
#include "exponential.glsl"

float far_density = 0.0;        // at the end of the step before, along a ray

float end_density(Sample s) {
    groomed(s.density = groom_depth(s.density, s.root);)
    return clamp(modulate(s.density, s), 0.0, 1.0);
}

vec4 classify(vec3 x, float path) {
    vec3 half_segment = mat3(texture_matrix) * (to_eye() * (0.5 * path));
    vec2 size = vec2(textureSize(segment_map, 0));
    Sample far = sample_object(x - half_segment);
    distance_bound = far.distance_bound;
    float near_density = far_density;
    if (!follows) near_density = end_density(sample_object(x + half_segment));
    far_density = end_density(far);
    vec2 ends = vec2(near_density, far_density);
    vec4 matter = lookup_plane(segment_map, (ends * (size - 1.0) + 0.5) / size);
    if (matter.a <= 0.0) return vec4(0.0);
    float alpha = matter.a >= 1.0 ? 1.0 : -exp_minus_one(path / step_size * log_one_minus(matter.a));
    groomed(matter.rgb = matter.a * groom_color(matter.rgb / matter.a, far.root);)
    return vec4(matter.rgb / matter.a * alpha, alpha);
}
