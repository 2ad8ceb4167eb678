// Turbulence summed octave by octave, of whatever strategy gives an octave: both functions.
// Source: PH 2.3, MJ Eq. 4: sum of |noise(2^i p)| / 2^i.
// p, width, enough and results: as octave_gradient.glsl has them.
#include "octave_gradient.glsl"

float turbulence(vec3 p, float width, float enough) {
    float sum = 0.0, scale = 1.0, share = 1.0;
    for (int index = 0; index < octaves_held(); ++index) {
        float weight = octave_weight(scale * width);
        float noise = weight > 0.0 ? abs(octave(scale * p, index)) : 0.0;
        sum += mix(OCTAVE_MEAN, noise, weight) * share;
        if (sum >= enough) break;
        scale *= 2.0;
        share *= 0.5;
    }
    return sum;
}
