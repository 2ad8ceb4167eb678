#version 450
// One ray through the picture, composited front to back, in a compute shader: the picture of march.frag, to the bit.
// Source: PH 3.1; see march.frag.
// Result: premultiplied linear RGBA.
#define COMPUTE
#include "interface.glsl"
#include "vector.glsl"
layout(set = 0, binding = 61, rgba32f) uniform writeonly image2D picture;
vec4 fragment;
#include "ray.glsl"

void main() {
    ivec2 pixel = ivec2(pixel_center);
    if (any(greaterThanEqual(pixel, area_end))) return;
    march();
    imageStore(picture, pixel, fragment);
}
