#version 450
// One ray through the picture, sampled where the slices are, composited front to back.
// Source: PH 3.1; MJ 7 (fragment shader loops). The samples are those of the slice pass, so that both give one picture.
// Result: premultiplied linear RGBA.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) out vec4 fragment;
vec3 position_eye;                      // eye space
vec4 color = vec4(1.0);
bool follows = false;                   // the sample taken last is one step nearer to the eye
mat3 ray_basis;                         // along the ray and to two sides, unit vectors, eye space
#include <projection>
#include <jitter>
#include <clip>
#include <classify>
#include <empty_space>
#include "box_intersection.glsl"

void main() {
    vec2 ndc = gl_FragCoord.xy * picture_scale.xy - 1.0 + picture_scale.zw;
    vec3 from = (texture_matrix * vec4(ray_at(ndc, 0.0), 1.0)).xyz;
    vec3 along = mat3(texture_matrix) * (ray_at(ndc, 1.0) - ray_at(ndc, 0.0));
    vec2 boxed = intersect_box(from, along), round = ball_crossing(from, along);
    vec2 inside = vec2(max(boxed.x, round.x), min(boxed.y, round.y));
    float phase = sample_phase();
    float first = max(ceil((inside.x - first_depth) / step_size - phase), 0.0); // PH 3.1: x = x_mu0 + k dx
    float last = min(floor((inside.y - first_depth) / step_size - phase), slice_count - 1.0);
    vec4 sum = vec4(0.0);
    float step_length = step_size * length(along);
    float next = 1.0;
    position_eye = ray_at(ndc, 1.0);
    ray_basis = ray_basis_of();
    for (float k = first; k <= last; k += next) {
        next = 1.0;
        position_eye = ray_at(ndc, first_depth + (k + phase) * step_size);
        vec3 x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
        if (clipped(x)) {
            follows = false;
            continue;
        }
        vec4 matter = classify(x, step_size * path_scale());
        next = advance(step_length);
        follows = next == 1.0;
        sum += (1.0 - sum.a) * matter;                                          // PH 3.1: front to back
        if (sum.a >= full_opacity) break;                                       // PH 3.1: until opaque
    }
    fragment = sum;
}
