// Noise computed in place, as bounds of it know it: looked up as if it were an image of all its cells, whose level is its
// period. Never drawn.
// Source: ours; of src/noise/range.rs.
// p: lattice cells; result: gradient per cell in xyz, noise in w.
// @loops 1
#include <wrap>
vec4 noise_gradient(vec3 p) {
    vec4 n = textureLod(noise_block, folded(p, noise_period), noise_period);
    return vec4(n.xyz * fold_sign(p, noise_period), n.w);
}
float noise(vec3 p) { return noise_gradient(p).w; }
