// Noise of many frequencies added to the density of the soft region.
// Source: PH 2.4 (combining frequencies); position-dependent: f(x).
// density: any; result: density plus at most 1.733 of the strength.
// @drift fractal_speed * fractal_scale
// @param fractal_strength = 0.8 in [-4, 4]: Amplitude of the first octave in the middle of the soft region.
// @param fractal_scale = 3 in [0.1, 50]: Noise cells of the first octave per object unit.
// @param fractal_speed = 0 in [0, 8]: How fast the pattern rises, object units per second.
#include "fractal_sum.glsl"
#include "soft_part.glsl"
#include <phases>
float fractal(float density, Sample s) {
    vec3 p = s.x - vec3(0.0, fractal_speed * time, 0.0);
    float sum = fractal_sum(fractal_scale * p, fractal_scale * sample_width());
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -fractal_scale * fractal_speed, 0.0);
        float before = fractal_sum(earlier(fractal_scale * p, velocity), fractal_scale * sample_width());
        sum = passing(sum, before, velocity, 2.0 * NOISE_RANGE);
    )
    return density + fractal_strength * soft_part(s) * sum;
}
