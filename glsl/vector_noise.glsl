// Noise with three components that do not know of each other: the scalar noise at three places far apart.
// Source: PH 2.4 (tribble): [noise(p - s), noise(p), noise(p + s)].
// p: lattice cells; result: each component as <noise>, length <= 1.5.
#include <noise>
// Neither s nor 2 s comes near a multiple of the period of a noise block (2 to 64 cells) or of PH's table (256): there
// components would be equal. No whole numbers: at those all components would vanish together. These numbers: the
// correlations that are left in the shipped blocks, of 4096 cells, are below 0.01.
const vec3 NOISE_SHIFT = vec3(13.2, 5.82, 7.11);

#ifdef FOUR_NOISES
vec3 vector_noise(vec3 p) { return four_noises(p).rgb; }

vec3 vector_noise_slope(vec3 p, out mat3 slope) {
    const vec2 h = vec2(0.5, 0.0);
    slope = mat3(vector_noise(p + h.xyy) - vector_noise(p - h.xyy), vector_noise(p + h.yxy) - vector_noise(p - h.yxy),
                 vector_noise(p + h.yyx) - vector_noise(p - h.yyx));
    return vector_noise(p);
}
#else
vec3 vector_noise(vec3 p) { return vec3(noise(p - NOISE_SHIFT), noise(p), noise(p + NOISE_SHIFT)); }

// Vector noise and its derivative by p: a row for each component.
vec3 vector_noise_slope(vec3 p, out mat3 slope) {
    vec4 a = noise_gradient(p - NOISE_SHIFT), b = noise_gradient(p), c = noise_gradient(p + NOISE_SHIFT);
    slope = transpose(mat3(a.xyz, b.xyz, c.xyz));
    return vec3(a.w, b.w, c.w);
}
#endif
