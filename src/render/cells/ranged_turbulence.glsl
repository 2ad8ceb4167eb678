// Turbulence computed in place, as bounds of it know it: see ranged_noise.glsl. Never drawn.
// p, width, enough and results: as octave_sum.glsl has them.
// @loops 1
#include "octave_sum.glsl"
#include "octave_lattice.glsl"
int octaves_held() { return OCTAVES; }
vec4 octave_gradient(vec3 p, int index) {
    float period = float(octave_mask(index) + 1u);
    vec4 n = textureLod(noise_block, folded(p, period), period);
    return vec4(n.xyz * fold_sign(p, period), n.w);
}
float octave(vec3 p, int index) { return octave_gradient(p, index).w; }
