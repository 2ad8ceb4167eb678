// Debug look: noise as grey, on a plane.
// Source: MJ 4.1, Fig. 5a.
// Result: linear grey, the square of 0.5 + 0.5 noise: in sRGB about the texel of the block.
#include "plane_point.glsl"
#include <noise>
vec3 surface(Sample s) {
    float texel = 0.5 + 0.5 * noise(plane_point(s));
    return vec3(texel * texel);
}
