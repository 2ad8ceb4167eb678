// Noise of many frequencies summed with its sign, each octave twice as fine and half as strong.
// Source: PH 2.4 (fractal sphere): sum of noise(2^i p) / 2^i. Beside turbulence, which sums absolute values.
// p: lattice cells of the first octave; result: gradient per cell in xyz, the sum in w, |sum| <= 1.71.
#include <noise>
const int FRACTAL_OCTAVES = 6;

vec4 fractal_sum_gradient(vec3 p) {
    vec4 sum = vec4(0.0);
    float scale = 1.0;
    for (int octave = 0; octave < FRACTAL_OCTAVES; ++octave) {
        vec4 n = noise_gradient(scale * p);
        sum += vec4(n.xyz, n.w / scale);    // 2^i of the chain rule and 1 / 2^i of the weight cancel
        scale *= 2.0;
    }
    return sum;
}
float fractal_sum(vec3 p) { return fractal_sum_gradient(p).w; }
