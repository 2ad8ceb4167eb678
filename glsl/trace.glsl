// The result of each pixel, in a fragment shader or, to the bit alike, in a compute shader.
// Source: -
// The entry defines trace(), which sets `fragment`. TEXEL is the format of the picture, and NEIGHBORS whether trace() reads
// other pixels of its group, so that those beyond the area are traced too.
#include "pixel.glsl"
void trace();

#ifdef COMPUTE
#ifndef TEXEL
#define TEXEL rgba32f
#endif
layout(set = 0, binding = 61, TEXEL) uniform writeonly image2D picture;
vec4 fragment;

void main() {
    ivec2 pixel = ivec2(pixel_center);
    bool beyond = any(greaterThanEqual(pixel, area_end));
#ifndef NEIGHBORS
    if (beyond) return;
#endif
    trace();
    if (!beyond) imageStore(picture, pixel, fragment);
}
#else
layout(location = 0) out vec4 fragment;

void main() { trace(); }
#endif
