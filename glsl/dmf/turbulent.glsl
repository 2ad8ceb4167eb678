// Turbulence eats the density away: what is thin goes first.
// Source: PH 2.3 (turbulence as a base function); position-dependent: f(x).
// density: any; result: the density times a factor that falls with the turbulence and is never negative.
// @drift turbulence_rise * turbulence_scale
// @param turbulence_strength = 1 in [0, 4]: How much the turbulence takes away.
// @param turbulence_scale = 3 in [0.1, 50]: Turbulence cells of the first octave per object unit.
// @param turbulence_rise = 0 in [0, 8]: How fast the pattern rises, object units per second.
#include <turbulence>
#include <phases>
float turbulent(float density, Sample s) {
    if (s.density >= 1.0) return density;
    vec3 p = s.x - vec3(0.0, turbulence_rise * time, 0.0);
    float enough = 1.0001 / max(turbulence_strength, 1e-6);     // nothing is left
    float sum = turbulence(turbulence_scale * p, turbulence_scale * sample_width(), UNTIL(enough));
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -turbulence_scale * turbulence_rise, 0.0);
        float before = turbulence(earlier(turbulence_scale * p, velocity), turbulence_scale * sample_width(), ALL);
        sum = passing(sum, before, velocity, SUM_RANGE);
    )
    return density * max(1.0 - turbulence_strength * sum, 0.0);
}
