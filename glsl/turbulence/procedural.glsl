// Turbulence summed octave by octave from slot <noise>.
// Source: PH 2.3, MJ Eq. 4: sum of |noise(2^i p)| / 2^i.
// p: lattice cells of the first octave; result: gradient per cell in xyz, the sum in w, in [0, 2].
#include <noise>
const int OCTAVES = 8;

vec4 turbulence_gradient(vec3 p) {
    vec4 sum = vec4(0.0);
    float scale = 1.0;
    for (int octave = 0; octave < OCTAVES; ++octave) {
        vec4 n = noise_gradient(scale * p);
        float side = n.w < 0.0 ? -1.0 : 1.0;
        sum.xyz += side * n.xyz;            // 2^i of the chain rule and 1 / 2^i of the weight cancel
        sum.w += abs(n.w) / scale;
        scale *= 2.0;
    }
    return sum;
}
float turbulence(vec3 p) { return turbulence_gradient(p).w; }
