// Vector noise, or in the right half its derivative along (0.6, -0.5, 0.62).
// Source: PH 2.4.
// Result: 0.5 + 0.5 noise, 0.5 + 0.1 derivative.
#include "vector_noise.glsl"
vec3 surface(Sample s) {
    mat3 slope;
    s.x.z = 0.37;
    vec3 n = vector_noise_slope(4.0 * s.x, slope);
    return s.x.x < 0.0 ? 0.5 + 0.5 * n : 0.5 + 0.1 * (slope * vec3(0.6, -0.5, 0.62));
}
