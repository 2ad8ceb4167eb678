// Noise by one fetch from the precomputed block, repeated without end: with its gradient, or alone from one channel.
// Source: MJ 4.1: gradient in RGB, noise in A.
// A block has one level, and is read at places of which no derivative is defined: in loops and branches.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 1.
#include <filter>
#include <wrap>
const float NOISE_GRADIENT_BOUND = 3.0;     // as baked; the gradient of the noise never exceeds 2.8

vec4 fetched_noise_gradient(vec3 p) {
    vec4 texel = 2.0 * lookup_block(noise_block, p / noise_cells, 0.0) - 1.0;
    return vec4(texel.rgb * fold_sign(p, noise_cells) * NOISE_GRADIENT_BOUND, texel.a);
}
float fetched_noise(vec3 p) { return 2.0 * lookup_block(noise_value_block, p / noise_cells, 0.0).r - 1.0; }
