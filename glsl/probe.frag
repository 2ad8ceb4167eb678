#version 450
#define ONE_SAMPLE
// One sample of one ray, anywhere on it and for any path: what the reference picture integrates. Evaluated, never drawn.
// Source: PH 3.1.
// place: depth of the sample, and the depth that it stands for. Results: premultiplied linear RGBA; and in `space` the
// depths at which the ray enters and leaves the box and the ball around the soft region, and how much deeper no matter is.
#include "interface.glsl"
#include "vector.glsl"
#include "distance_bound.glsl"
layout(location = 0) in vec4 place;
layout(location = 0) out vec4 fragment;
layout(location = 1) out vec4 space;
vec3 position_eye;                      // eye space
vec4 color = vec4(1.0);
bool follows = false;                   // no sample was taken before
mat3 ray_basis;                         // along the ray and to two sides, unit vectors, eye space
#include <projection>
#include <jitter>
#include <clip>
#include <classify>
#include "box_intersection.glsl"

void main() {
    vec2 ndc = gl_FragCoord.xy * picture_scale.xy - 1.0 + picture_scale.zw;
    vec3 from = (texture_matrix * vec4(ray_at(ndc, 0.0), 1.0)).xyz;
    vec3 along = mat3(texture_matrix) * (ray_at(ndc, 1.0) - ray_at(ndc, 0.0));
    position_eye = ray_at(ndc, 1.0);
    ray_basis = ray_basis_of();
    position_eye = ray_at(ndc, place.x);
    vec3 x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
    vec4 matter = classify(x, place.y * path_scale());
    fragment = clipped(x) ? vec4(0.0) : matter;
    vec2 boxed = intersect_box(from, along), round = ball_crossing(from, along);
    space = vec4(max(boxed.x, round.x), min(boxed.y, round.y), distance_bound / length(along), 0.0);
}
