#version 450
// Directions from the axis of a light to half a turn away: their places on the map of shadows, and the device's sines.
// Source: light_space.glsl, which has no sines.
// Result: x of the place, sine and cosine of the angle, and the angle by atan; the angle is the pixel's part of 64 x 64.
layout(location = 0) out vec4 fragment;
const mat4 shadow_matrix = mat4(1.0);
const float shadow_rim = 2.8284271, shadow_near = 0.0, shadow_far = 4.0;
#include "light_space.glsl"
void main() {
    float angle = 3.14159265 * ((floor(gl_FragCoord.x) + 64.0 * floor(gl_FragCoord.y)) / 4096.0);
    float across = sin(angle), along = cos(angle);
    fragment = vec4(to_light_space(vec3(across, 0.0, along)).x, across, along, atan(across, along));
}
