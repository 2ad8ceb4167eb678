#version 450
// Texels of the shadow volume, in a compute shader: those of shadow.frag, to the bit.
// Source: PH 4 and MJ 7.
// Result: transmittances in [0, 1].
#define COMPUTE
#include "interface.glsl"
#include "vector.glsl"
layout(set = 0, binding = 61, rgba32f) uniform writeonly image2D picture;
vec4 fragment;
#include "shadow.glsl"

void main() {
    ivec2 pixel = ivec2(pixel_center);
    if (any(greaterThanEqual(pixel, area_end))) return;
    cast_light();
    imageStore(picture, pixel, fragment);
}
