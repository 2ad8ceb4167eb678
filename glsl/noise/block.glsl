// Noise by one fetch from the precomputed block, repeated without end.
// Source: MJ 4.1: gradient in RGB, noise in A.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 1.
const float NOISE_GRADIENT_BOUND = 3.0;     // as baked; the gradient of the noise never exceeds 2.8

vec4 noise_gradient(vec3 p) {
    vec4 texel = 2.0 * texture(noise_block, p / noise_cells) - 1.0;
    return vec4(texel.rgb * NOISE_GRADIENT_BOUND, texel.a);
}
float noise(vec3 p) { return noise_gradient(p).w; }
