// The light that reaches a slice through those before it, from the buffers of the light.
// Source: GG 39.5.1; Kniss et al. 2003 (the chapter is cut: a reconstruction).
// guess: unused; normal: of a hard surface, eye space, or 0 for soft matter. Result: linear RGB, in [0, 1].
// Soft matter is lit in the middle of its slice, by the mean of the light before and behind it: second order. A hard
// surface is lit by that before it, looked up off itself, so that the slice before does not spot it.
#include "light_space.glsl"
#include <filter>
vec3 shadow(float guess, vec3 normal) {
    vec2 ray = to_light_space(position_eye + shadow_bias * normal).xy;
    vec4 light = lookup_plane(light_before, ray);
    if (normal == vec3(0.0)) light = 0.5 * (light + lookup_plane(light_behind, ray));
    return mix(vec3(light.a), light.rgb, translucency);
}
