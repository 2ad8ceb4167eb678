#version 450
// How much light one segment of a ray from the light lets through: a texel of the shadow volume before the products
// along the rays are taken. The matter is that of the picture, by the modules of the scene.
// Source: PH 4 and MJ 7 (shadows by preprocessing); PH 3.1 (opacity of a segment).
// A square of rays for each distance, side by side. Result: transmittance in [0, 1].
#include "interface.glsl"
#include "vector.glsl"
#include "light_space.glsl"
layout(location = 0) out float fragment;
vec3 position_eye;                      // eye space
vec4 color = vec4(1.0);

// What looks at the matter is the light.
vec3 to_eye() { return safe_normalize(light_position.xyz - position_eye, vec3(0.0, 0.0, 1.0)); }
#include <clip>
#include <classify>

void main() {
    float columns = ceil(sqrt(shadow_side));
    vec2 square = floor(gl_FragCoord.xy / shadow_side);
    vec2 ray = gl_FragCoord.xy / shadow_side - square;
    float layer = square.y * columns + square.x;
    float path = (shadow_far - shadow_near) / (shadow_side * shadow_steps);
    fragment = 1.0;
    if (layer >= shadow_side) return;
    for (float i = 0.5; i < shadow_steps; i += 1.0) {
        position_eye = from_light_space(vec3(ray, (layer + i / shadow_steps) / shadow_side));
        vec3 x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
        if (any(lessThan(x, box_min.xyz)) || any(greaterThan(x, box_max.xyz)) || clipped(x)) continue;
        fragment *= 1.0 - clamp(classify(x, path).a, 0.0, 1.0);
    }
}
