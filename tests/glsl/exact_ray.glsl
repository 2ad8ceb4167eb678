#version 450
// Inputs of rays, at points, for tests of the exact evaluator.
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
#include <jitter>
#include <clip>
#define ONE_SAMPLE    // bounds follow no search whose turns they cannot decide
#include <classify>
#include <empty_space>
#include <cells>
#include "box_intersection.glsl"

void main() {
    vec3 x = 0.75 * point().xyz;
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    ray_basis = ray_basis_of();
    vec4 matter = classify(x, 0.015625);
    vec3 far = ray_at(x.xy, 3.0 + x.z);
    vec3 kept = clipped(x) ? vec3(0.0) : vec3(1.0, sample_phase(), 0.0);
    float steps = advance(0.25) + 0.0625 * min(empty_steps(x, vec3(0.05, -0.04, 0.03 + 0.01 * x.z), 0.0), 16.0);
    fragment = vec4(kept.x + kept.y, steps, path_scale() + far.y, 0.125 * intersect_box(vec3(x.xy, 3.0), vec3(0.1, x.z, -1.0)).x + matter.a);
}
