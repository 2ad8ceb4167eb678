// Turbulence by one fetch from a block in which every octave is already summed: with its gradient, or alone.
// Source: MJ 4.1: best quality and speed. The sum never ends early. Octaves fade by the levels of the block.
// p, width, enough and results: as octave_gradient.glsl has them, but the sum is in [0, 2].
// @exact procedural turbulence_block
// @loops 0
// @octaves turbulence_block
// @period memory
#include "octave_constants.glsl"
#include "octave_levels.glsl"
#include <filter>
#include <wrap>
const float TURBULENCE_GRADIENT_BOUND = 24.0;   // as baked; eight octaves never exceed 22.4

vec4 turbulence_gradient(vec3 p, float width) {
    float level = octave_level(width, turbulence_octaves);
    vec4 texel = lookup_block(turbulence_block, p / turbulence_cells, level);
    return vec4((2.0 * texel.rgb - 1.0) * fold_sign(p, turbulence_cells) * TURBULENCE_GRADIENT_BOUND, 2.0 * texel.a);
}
float turbulence(vec3 p, float width) {
    float level = octave_level(width, turbulence_octaves);
    return 2.0 * lookup_block(turbulence_value_block, p / turbulence_cells, level).r;
}
vec4 turbulence_gradient(vec3 p) { return turbulence_gradient(p, 0.0); }
vec4 turbulence_gradient(vec3 p, float width, float enough) { return turbulence_gradient(p, width); }
float turbulence(vec3 p) { return turbulence(p, 0.0); }
float turbulence(vec3 p, float width, float enough) { return turbulence(p, width); }
