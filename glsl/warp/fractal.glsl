// Noise of many frequencies scales the distance from the center: the characteristic fractal look.
// Source: PH 2.4 (fractal sphere): D(x (1 + sum noise(2^i f x) / (2^i f))); the amplitude is 1 / f in the paper.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move 2 * noise_bound * fractal_amplitude * hold_radius
// @param fractal_amplitude = 0.4 in [0, 1]: Amplitude of the first octave, object units; in the paper 1 / fractal_frequency; the next is half as high.
// @param fractal_frequency = 2.5 in [0.2, 20]: Frequency of the first octave: bumps per object unit; the next is twice as fine.
#include "fractal_sum.glsl"
#include "scale_radius.glsl"
void fractal(inout vec3 x, inout mat3 jacobian) {
    vec3 p = fractal_frequency * x;
    float width = fractal_frequency * sample_width();
    vec4 n = fractal_amplitude * moved_by(fractal_sum_gradient(p, width), fractal_sum(p, width));
    scale_radius(x, jacobian, n.w, fractal_frequency * n.xyz);
}
