// Noise whose gain is paid for by amplitude: the sharper its bumps, the lower, so that the steepest slope of the density,
// which decides how fine a picture must be sampled, stays what it is.
// Source: PH 3.1, footnote: tradeoffs between base functions, in which more gain forces the amplitude that suits it; the
// form is ours: gain g has the slope -log2(1 - g) in its middle. Position-dependent: f(x).
// density: any; result: density plus at most the strength, over that slope.
// @param trade_gain = 0.75 in [0.5, 0.99]: Gain of the noise; 0.5 leaves it as it is, and so its amplitude.
// @param trade_strength = 0.6 in [-4, 4]: Amplitude in the middle of the soft region, at a gain of 0.5.
// @param trade_frequency = 6 in [0.1, 100]: Noise cells per object unit.
#include <noise>
#include "shaping.glsl"
#include "soft_part.glsl"
float traded(float density, Sample s) {
    float bumps = 2.0 * gain(trade_gain, 0.5 + 0.5 * noise(trade_frequency * s.x)) - 1.0;
    return density + trade_strength * soft_part(s) * bumps / -log2(1.0 - trade_gain);
}
