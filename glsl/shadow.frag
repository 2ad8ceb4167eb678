#version 450
// How much light four segments of a ray from the light let through: four texels of the shadow volume before the products
// along the rays are taken. The matter is that of the picture, by the modules of the scene.
// Source: PH 4 and MJ 7 (shadows by preprocessing); PH 3.1 (opacity of a segment).
// A square of rays for each four distances, side by side. Result: transmittances in [0, 1], in order of the distance.
#include "interface.glsl"
#include "vector.glsl"
#include "light_space.glsl"
layout(location = 0) out vec4 fragment;
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample of the ray was taken before this one
vec4 color = vec4(1.0);

// What looks at the matter is the light.
vec3 to_eye() { return safe_normalize(light_position.xyz - position_eye, vec3(0.0, 0.0, 1.0)); }
// A sample is as wide as a step of this ray, or of those of the picture.
float path_scale() { return 1.0; }
float pixel_width() { return (shadow_far - shadow_near) / (shadow_side * shadow_steps); }
#include <clip>
#include <classify>
#include <empty_space>

void main() {
    float columns = ceil(sqrt(ceil(shadow_side / 4.0)));
    vec2 square = floor(gl_FragCoord.xy / shadow_side);
    vec2 ray = gl_FragCoord.xy / shadow_side - square;
    float first = 4.0 * (square.y * columns + square.x);
    float path = (shadow_far - shadow_near) / (shadow_side * shadow_steps);
    fragment = vec4(1.0);
    float next = 1.0;
    for (float i = 0.0; i < 4.0 * shadow_steps && first < shadow_side; i += next) {
        next = 1.0;
        position_eye = from_light_space(vec3(ray, (first + (i + 0.5) / shadow_steps) / shadow_side));
        vec3 x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
        if (any(lessThan(x, box_min.xyz)) || any(greaterThan(x, box_max.xyz)) || clipped(x)) continue;
        int segment = int(i / shadow_steps);
        fragment[segment] *= 1.0 - clamp(classify(x, path).a, 0.0, 1.0);
        if (fragment[segment] <= 0.0) break;            // what is behind is dark whatever it is
        next = advance(path * length(mat3(texture_matrix) * to_eye()));
    }
}
