// Noise scales the distance from the center: bumps and dents.
// Source: PH 2.4 (noisy sphere): D(x (1 + noise(f x) / f)); the amplitude is a parameter of its own, 1 / f in the paper.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move noise_bound * amplitude * hold_radius
// @param amplitude = 0.25 in [0, 1.1]: Amplitude of the noise, object units: the height of a bump on the unit sphere; in the paper 1 / frequency.
// @param frequency = 4 in [0.2, 40]: Frequency of the noise: bumps per object unit.
#include <noise>
#include "scale_radius.glsl"
void noisy(inout vec3 x, inout mat3 jacobian) {
    vec4 n = amplitude * moved_by(noise_gradient(frequency * x), noise(frequency * x));
    scale_radius(x, jacobian, n.w, frequency * n.xyz);
}
