#version 450
// The linear filter across the cell between two texels of a volume.
// Source: -
// Result: the filtered value; the pixel's column is the place in the cell, 0 to 1 over 256 pixels.
#include "interface.glsl"
layout(location = 0) out vec4 fragment;
void main() {
    float t = gl_FragCoord.x / 256.0;
    fragment = vec4(texture(volume, vec3(0.25 + 0.5 * t, 0.5, 0.5)).r, 0.0, 0.0, 1.0);
}
