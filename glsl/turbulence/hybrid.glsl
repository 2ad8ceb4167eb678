// Turbulence in two parts: the low octaves summed in a block, which holds them well, in one fetch; the high ones, which a
// block of that size cannot hold, computed in place where the low ones leave room for them.
// Source: ours, of MJ 4.1 (pre-compute) and 4.2 (compute).
// p, width, enough and results: as octave_gradient.glsl has them; a gradient is computed in all octaves.
// @exact procedural turbulence_block
// @loops 1
// @period turbulence_block
#include "octave_gradient.glsl"
#include "octave_lattice.glsl"
#include "octave_levels.glsl"
#include <filter>
int octaves_held() { return OCTAVES; }
float octave(vec3 p, int index) { return lattice_noise(p, octave_mask(index)); }
vec4 octave_gradient(vec3 p, int index) { return lattice_noise_gradient(p, octave_mask(index)); }

float turbulence(vec3 p, float width, float enough) {
    float level = octave_level(width, low_octaves);
    float sum = 2.0 * lookup_block(low_octaves_block, p / turbulence_cells, level).r;
    int first = int(low_octaves);
    float scale = exp2(low_octaves), share = 1.0 / scale;
    for (int index = first; index < OCTAVES; ++index) {
        if (sum >= enough) break;
        float weight = octave_weight(scale * width);
        float noise = weight > 0.0 ? abs(octave(scale * p, index)) : 0.0;
        sum += mix(OCTAVE_MEAN, noise, weight) * share;
        scale *= 2.0;
        share *= 0.5;
    }
    return sum;
}
