// Noise added to the density of the soft region.
// Source: PH 2.3 (noise as a base function); position-dependent: f(x).
// density: any; result: density plus at most 0.866 of the strength.
// @param noise_strength = 0.5 in [-4, 4]: Amplitude of the noise in the middle of the soft region.
// @param noise_frequency = 6 in [0.1, 100]: Noise cells per object unit.
#include <noise>
#include "soft_part.glsl"
float noisy(float density, Sample s) {
    return density + noise_strength * soft_part(s) * noise(noise_frequency * s.x);
}
