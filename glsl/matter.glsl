// Density and color of the matter at a point; the opacity of the scene is the density itself.
// Source: PH 2 and MJ 6 (the modulated density).
// x: object space; result: linear RGB multiplied by the density in A, zeros beyond the box around the matter.
#define ONE_SAMPLE
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample was taken before
vec4 color = vec4(1.0);
mat3 ray_basis;                         // along the ray and to two sides, unit vectors, eye space
#include <projection>
#include <clip>
#include <classify>

vec4 matter_at_point(vec3 x) {
    position_eye = (object_matrix * vec4(x, 1.0)).xyz;
    ray_basis = ray_basis_of();
    bool inside = all(greaterThanEqual(x, box_min.xyz)) && all(lessThanEqual(x, box_max.xyz));
    return inside ? classify(x, step_size) : vec4(0.0);
}
