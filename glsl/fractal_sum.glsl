// Noise of many frequencies summed with its sign, each octave twice as fine and half as strong.
// Source: PH 2.4 (fractal sphere): sum of noise(2^i p) / 2^i; PH 3.1: octaves finer than a sample are left out. Beside
// turbulence, which sums absolute values.
// p: lattice cells of the first octave; width: of a sample, in the same cells; result: gradient per cell in xyz, the sum
// in w, |sum| <= 1.733. An octave that fades leaves its mean, 0.
#include <noise>
#include "octave_constants.glsl"

vec4 fractal_sum_gradient(vec3 p, float width) {
    vec4 sum = vec4(0.0);
    float scale = 1.0;
    for (int index = 0; index < OCTAVES; ++index) {
        float weight = octave_weight(scale * width);
        vec4 n = weight > 0.0 ? weight * noise_gradient(scale * p) : vec4(0.0);
        sum += vec4(n.xyz, n.w / scale);    // 2^i of the chain rule and 1 / 2^i of the weight cancel
        scale *= 2.0;
    }
    return sum;
}

float fractal_sum(vec3 p, float width) {
    float sum = 0.0, scale = 1.0;
    for (int index = 0; index < OCTAVES; ++index) {
        float weight = octave_weight(scale * width);
        sum += weight > 0.0 ? weight * noise(scale * p) / scale : 0.0;
        scale *= 2.0;
    }
    return sum;
}
