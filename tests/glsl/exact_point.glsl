#version 450
// Classified matter of a scene, at points, for tests of the exact evaluator.
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

void main() {
    vec3 x = 0.75 * point().xyz;
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    ray_basis = ray_basis_of();
    fragment = classify(x, 0.015625);
}
