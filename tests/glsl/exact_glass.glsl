#version 450
// Inputs of bending rays, at points, for tests of the exact evaluator.
#include "interface.glsl"
#include "vector.glsl"
#include "hash.glsl"
#include "index_point.glsl"
layout(location = 0) out vec4 fragment;
POINT
vec3 position_eye;
vec4 color = vec4(1.0);
#include <projection>
#include <clip>
#include <classify>
#include <empty_space>
#include <index>
#include <absorption>
#include <environment>
struct Ray {
    vec3 at;
    vec3 along;
    vec3 bent;
    Index medium;
};
vec3 object_space(vec3 at) { return mat3(texture_matrix) * at; }
#include <ray_path>

void main() {
    vec3 x = 0.75 * point().xyz;
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    Ray ray;
    ray.at = ray.bent = x;
    ray.along = safe_normalize(vec3(0.3, x.z, -1.0), vec3(0.0));
    ray.medium = index_at(x);
    vec4 seen = environment(x, ray.along, 0.0078125);
    ray = moved(ray, 0.0625);
    fragment = vec4(seen.rg + 0.25 * transmitted(abs(0.5 + 0.125 * x.x)).rg, ray.medium.value + 0.25 * classify(x, 0.015625).a, ray.at.x + ray.along.y);
}
