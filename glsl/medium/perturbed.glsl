// The color of the transfer map, made irregular by noise: brightness as a whole, and each channel for itself.
// Source: GG 39.5, first technique: optical properties are perturbed after the transfer function.
// density: modulated, in [0, 1]; result: linear RGB.
// @knob irregularity = 0.6 in [0, 2]: How far the brightness varies, as a part of it.
// @knob iridescence = 0.4 in [0, 2]: How far each channel varies for itself, as a part of it.
// @knob irregularity_frequency = 8 in [0.1, 100]: Noise cells per object unit.
// @knob irregularity_speed = 0 in [0, 8]: How fast the noise drifts, cells per second.
#include "transfer.glsl"
#include "vector_noise.glsl"
vec3 medium(Sample s, float density) {
    vec3 p = irregularity_frequency * s.x - vec3(0.0, irregularity_speed * time, 0.0);
    vec3 factor = 1.0 + irregularity * noise(2.0 * p + 29.3) + iridescence * vector_noise(p);
    return transfer(density).rgb * max(factor, 0.0);
}
