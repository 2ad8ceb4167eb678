// Random numbers in the four channels of the texels of a small block, slightly blurred, which hides the trilinear filter.
// Source: GG 39.5; quality.block_blur is the width of the blur in texels.
// p: texels; result: gradient per texel in xyz, by differences over one; noise in w, |noise| <= 1.
// @bound 1
// One fetch gives four noises, which vector_noise.glsl and four_noises.glsl take in place of noise at other places.
// @loops 1
// @period memory
#include <filter>
#define FOUR_NOISES
#define NOISE_MEAN random_mean
vec4 four_noises(vec3 p) { return 2.0 * lookup_block(random_block, p / vec3(textureSize(random_block, 0)), 0.0) - 1.0; }
float noise(vec3 p) { return four_noises(p).a; }
vec4 noise_gradient(vec3 p) {
    const vec2 h = vec2(0.5, 0.0);
    return vec4(noise(p + h.xyy) - noise(p - h.xyy), noise(p + h.yxy) - noise(p - h.yxy),
                noise(p + h.yyx) - noise(p - h.yyx), noise(p));
}
