#version 450
#define ONE_SAMPLE
// The light behind one slice, from the light before it: half-angle slicing, as the light sees it. The matter is that of the
// picture, by the modules of the scene.
// Source: GG 39.5.1; Kniss et al. 2003.
// depth: of the slice, eye space. Result: scattered light in RGB and direct light in A, in [0, 1].
#include "interface.glsl"
#include "vector.glsl"
#include "light_space.glsl"
layout(location = 0) flat in float depth;
layout(location = 0) out vec4 fragment;
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample of the ray was taken before this one
vec4 color = vec4(1.0);

// The eye is the light.
vec3 to_eye() { return safe_normalize(light_position.xyz - position_eye, vec3(0.0, 0.0, 1.0)); }
#include <planes>
// A sample is as wide as the path in its slice, or as a texel of the buffer.
float path_scale() { return 1.0 / max(-plane_depth(to_eye()), 1e-6); }
float pixel_width() { return 2.0 * shadow_rim * length((shadow_matrix * vec4(position_eye, 1.0)).xyz) / shadow_side; }
#include <clip>
#include <classify>
#include <scatter>

void main() {
    vec2 ray = gl_FragCoord.xy / shadow_side;
    vec3 from = from_light_space(vec3(ray, 0.0)), along = from_light_space(vec3(ray, 1.0)) - from;
    float thick = plane_depth(along), path = step_size * length(along) / thick;
    position_eye = from + along * ((depth - plane_depth(from)) / thick);
    vec3 x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
    float left = 1.0;
    if (all(greaterThanEqual(x, box_min.xyz)) && all(lessThanEqual(x, box_max.xyz)) && !clipped(x)) {
        left -= clamp(classify(x, path).a, 0.0, 1.0);
    }
    fragment = passed(ray, left, path);
}
