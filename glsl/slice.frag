#version 450
// One fragment of one proxy slice: rejected, or a premultiplied color for the Over operator.
// Source: MJ 3.5 and 3.6.
// Slot <sampling> declares what comes from the vertices, and says where the sample is.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) out vec4 fragment;
vec3 position_eye;                      // eye space
vec4 color;                             // linear RGBA of the vertex
const bool follows = false;             // no sample of the ray was taken before this one
mat3 ray_basis;                         // along the ray and to two sides, unit vectors, eye space
#include <projection>
#include <sampling>
#include <jitter>
#include <clip>
#include <classify>
#include <reject>

void main() {
    vec3 x;
    place(position_eye, x);
    color = color_in;
    shift_sample(position_eye, x);
    ray_basis = ray_basis_of();
    vec4 matter = clipped(x) ? vec4(0.0) : classify(x, step_size * path_scale());
    if (matter.a <= 0.0) reject(matter);    // MJ 3.5
    fragment = matter;                  // MJ 3.6: blended by the Over operator
}
