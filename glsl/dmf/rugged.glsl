// A rough surface: noise of four octaves, which may be drawn out along the vertical axis and folded into ridges: stone, bark,
// or fuzz.
// Source: PH 2.4 (sums of noise); folding: Musgrave, in Ebert et al. 2003, "Texturing and Modeling" (ridged multifractal).
// Geometry-dependent.
// density: D in [0, 1]; result in [0, 1]; the hard region keeps its own.
// @needs normal
// @outer rough_height
// @param rough_height = 0.12 in [0.005, 0.5]: Height of the relief, object units: the width of the soft region.
// @param rough_frequency = 3 in [0.2, 100]: Noise cells of the coarsest octave per object unit, across the axis.
// @param rough_detail = 0.5 in [0, 0.8]: Strength of each octave, in that of the next coarser one.
// @param rough_stretch = 1 in [1, 20]: How much longer the noise is along the vertical axis.
// @param ridges = 0 in [0, 1]: 0 are lumps, 1 ridges with furrows between them.
#include <noise>
#include "relief.glsl"

float rugged(float density, Sample s) {
    if (s.density >= 1.0) return density;
    vec3 p = rough_frequency * foot_of(s) * vec3(1.0, 1.0 / rough_stretch, 1.0);
    float sum = 0.0, weight = 1.0, whole = 0.0;
    for (int octave = 0; octave < 4; ++octave) {
        float n = noise(p);
        sum += weight * mix(1.6 * n, 3.2 * abs(n) - 0.7, ridges);
        whole += weight;
        weight *= rough_detail;
        p = 2.0 * p + vec3(5.2, 1.3, 7.7);
    }
    return raised(density, s, smoothstep(-1.0, 1.0, 1.3 * sum / whole));
}
