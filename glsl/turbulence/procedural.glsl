// Turbulence summed octave by octave from slot <noise>.
// Source: PH 2.3, MJ Eq. 4: sum of |noise(2^i p)| / 2^i; PH 3.1: octaves finer than a sample are left out.
// p: lattice cells of the first octave; width: of a sample, in the same cells; result: gradient per cell in xyz, the
// sum in w, in [0, 2]. An octave that fades leaves its mean, so that the turbulence stays as bright as it is.
#include <noise>
#include <bandlimit>
layout(constant_id = 0) const int OCTAVES = 8;
const float MEAN_NOISE = 0.156;         // of |noise| with weights of 2002, as measured; of 1989: 0.148

vec4 turbulence_gradient(vec3 p, float width) {
    vec4 sum = vec4(0.0);
    float scale = 1.0;
    for (int octave = 0; octave < OCTAVES; ++octave) {
        float weight = octave_weight(scale * width);
        vec4 n = vec4(0.0);
        if (weight > 0.0) n = noise_gradient(scale * p);
        float side = n.w < 0.0 ? -1.0 : 1.0;
        sum.xyz += weight * (side * n.xyz);     // 2^i of the chain rule and 1 / 2^i of the weight cancel
        sum.w += mix(MEAN_NOISE, abs(n.w), weight) / scale;
        scale *= 2.0;
    }
    return sum;
}
vec4 turbulence_gradient(vec3 p) { return turbulence_gradient(p, 0.0); }
float turbulence(vec3 p, float width) { return turbulence_gradient(p, width).w; }
float turbulence(vec3 p) { return turbulence_gradient(p, 0.0).w; }
