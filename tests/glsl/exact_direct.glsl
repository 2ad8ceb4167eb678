#version 450
// Functions that few scenes call, at points, whatever is there.
#include "interface.glsl"
#include "vector.glsl"
#include "hash.glsl"
layout(location = 0) out vec4 fragment;
POINT
vec3 position_eye;
vec4 color = vec4(1.0);
const bool follows = false;
mat3 ray_basis;
#include <projection>
#include <planes>
#include <jitter>
#include "sample_point.glsl"
#include <bandlimit>
#include <softness>
#include <opacity>
#include <turbulence>
#include "four_noises.glsl"
#include "fractal_sum.glsl"
#include "bump_normal.glsl"
#include "light_space.glsl"
#include "box_intersection.glsl"

void main() {
    vec3 x = 0.75 * point().xyz, part = fract(x);
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    ray_basis = ray_basis_of();
    Sample s;
    s.x = x;
    s.normal = safe_normalize(x, vec3(0.0, 0.0, 1.0));
    vec4 noises = four_noises(x) + noise_gradient(x) + turbulence_gradient(x, part.x) + turbulence_gradient(x);
    float sums = noise(x) + turbulence(x) + turbulence(x, part.y) + turbulence(x, part.z, part.x);
    float thin = opacity(part.x, abs(x.y)) + segment_opacity(part.x, part.y, abs(x.z)) + segment_opacity(part.x, part.x, part.z);
    float soft = soften(x.x) + soften(x.y, x.y) + soften_unclamped(x.z) + sample_phase() + plane_depth(x);
    vec3 placed = from_light_space(part) + to_light_space(position_eye) + bump_normal(s);
    vec3 along = vec3(part.xy - 0.5, 1.0);   // no direction is 0
    vec2 crossed = intersect_box(x, along) + ball_crossing(x, along);
    fragment = noises + vec4(sums, thin, soft, pixel_width()) + vec4(placed, min(crossed.x, 1.0));
    shift_sample(position_eye, x);
    fragment.xyz += x + position_eye;
}
