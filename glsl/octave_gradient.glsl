// The gradient of turbulence summed octave by octave, of whatever strategy gives an octave.
// Source: PH 2.3, MJ Eq. 4: sum of |noise(2^i p)| / 2^i; PH 3.1: octaves finer than a sample are left out.
// Includes every other form of both functions; the sum alone is octave_sum.glsl's, or the strategy's own.
// p: lattice cells of the first octave; width: of a sample, in the same cells; enough: the sum may end where it is as
// large as this, for it only grows, to at most 1.733; result: gradient per cell in xyz, the sum in w, in [0, 1.733].
// An octave that fades leaves its mean, so that the turbulence stays as bright as it is: OCTAVE_MEAN, which a strategy
// with other octaves than gradient noise defines.
#include "octave_constants.glsl"
#include <weights>
#ifndef OCTAVE_MEAN
#define OCTAVE_MEAN MEAN_OF_GRADIENTS
#endif

// Of the strategy: how many octaves it has, and the noise of one of them at p, in cells of that octave.
int octaves_held();
float octave(vec3 p, int index);
vec4 octave_gradient(vec3 p, int index);
float turbulence(vec3 p, float width, float enough);

vec4 turbulence_gradient(vec3 p, float width, float enough) {
    vec3 slope = vec3(0.0);             // apart from the sum: where nobody reads it, the compiler leaves it out
    float sum = 0.0, scale = 1.0, share = 1.0;
    for (int index = 0; index < octaves_held(); ++index) {
        float weight = octave_weight(scale * width);
        vec4 n = weight > 0.0 ? octave_gradient(scale * p, index) : vec4(0.0);
        slope += n.w < 0.0 ? -weight * n.xyz : weight * n.xyz;      // 2^i of the chain rule and 1 / 2^i of the weight cancel
        sum += mix(OCTAVE_MEAN, abs(n.w), weight) * share;
        if (sum >= enough) break;
        scale *= 2.0;
        share *= 0.5;
    }
    return vec4(slope, sum);
}
float turbulence(vec3 p, float width) { return turbulence(p, width, ALL); }
float turbulence(vec3 p) { return turbulence(p, 0.0, ALL); }
vec4 turbulence_gradient(vec3 p, float width) { return turbulence_gradient(p, width, ALL); }
vec4 turbulence_gradient(vec3 p) { return turbulence_gradient(p, 0.0, ALL); }
