// The color of the transfer map and the opacity, made irregular by noise: brightness as a whole, and each channel for itself.
// Source: GG 39.5, first method: four noises change optical properties after the transfer function.
// density: modulated, in [0, 1]; result: linear RGB; extinction: a factor of the opacity rate, at least 0.
// @drift irregularity_speed
// @param irregularity = 0.6 in [0, 2]: How far the brightness varies, as a part of it.
// @param iridescence = 0.4 in [0, 2]: How far each channel varies for itself, as a part of it.
// @param patchiness = 0 in [0, 2]: How far the opacity varies, as a part of it.
// @param irregularity_frequency = 8 in [0.1, 100]: Noise cells per object unit.
// @param irregularity_speed = 0 in [0, 8]: How fast the noise drifts, cells per second.
#include <transfer>
#include "four_noises.glsl"
#include <phases>
vec3 irregular_place(Sample s) { return irregularity_frequency * s.x - vec3(0.0, irregularity_speed * time, 0.0); }

vec4 irregular_noises(vec3 p) {
    vec4 n = four_noises(p);
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -irregularity_speed, 0.0);
        n = passing(n, four_noises(earlier(p, velocity)), velocity, NOISE_RANGE);
    )
    return n;
}

vec3 medium(Sample s, float density) {
    vec3 p = irregular_place(s);
    vec3 q = 2.0 * p + 29.3;
    float n = noise(q);
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -2.0 * irregularity_speed, 0.0);
        n = passing(n, noise(earlier(q, velocity)), velocity, NOISE_RANGE);
    )
    vec3 factor = 1.0 + irregularity * n + iridescence * irregular_noises(p).rgb;
    return transfer(density).rgb * max(factor, 0.0);
}

float extinction(Sample s, float density) { return max(1.0 + patchiness * irregular_noises(irregular_place(s)).a, 0.0); }
