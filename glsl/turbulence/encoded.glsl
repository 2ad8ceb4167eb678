// Turbulence by one fetch from a block in which every octave is already summed: with its gradient, or alone.
// Source: MJ 4.1: best quality and speed. What is summed cannot be taken apart: slot <bandlimit> has no effect here, and
// of a sample wider than a texel every octave aliases; turbulence/procedural fades them. Nor is there an end before all
// is summed.
// p: lattice cells of the first octave; result: gradient per cell in xyz, sum of |noise| / 2^i in w, in [0, 2].
// @exact procedural turbulence_block
#include "octave_constants.glsl"
#include <wrap>
const float TURBULENCE_GRADIENT_BOUND = 24.0;   // as baked; eight octaves never exceed 22.4

vec4 turbulence_gradient(vec3 p) {
    vec4 texel = texture(turbulence_block, p / turbulence_cells);
    return vec4((2.0 * texel.rgb - 1.0) * fold_sign(p, turbulence_cells) * TURBULENCE_GRADIENT_BOUND, 2.0 * texel.a);
}
float turbulence(vec3 p) { return 2.0 * texture(turbulence_value_block, p / turbulence_cells).r; }
vec4 turbulence_gradient(vec3 p, float width) { return turbulence_gradient(p); }
vec4 turbulence_gradient(vec3 p, float width, float enough) { return turbulence_gradient(p); }
float turbulence(vec3 p, float width) { return turbulence(p); }
float turbulence(vec3 p, float width, float enough) { return turbulence(p); }
