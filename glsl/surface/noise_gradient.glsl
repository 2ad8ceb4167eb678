// Debug look: the gradient of noise as a normal, as colors, on a plane.
// Source: MJ 4.1, Fig. 5b (gradient in RGB).
// Result: linear RGB, the square of 0.5 + 0.5 of the gradient, normalized: in sRGB about a map of normals.
#include "plane_point.glsl"
#include <noise>
vec3 surface(Sample s) {
    vec3 texel = 0.5 + 0.5 * safe_normalize(noise_gradient(plane_point(s)).xyz, vec3(0.0));
    return texel * texel;
}
