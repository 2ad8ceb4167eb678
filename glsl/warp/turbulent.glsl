// Turbulence scales the distance from the center: the object shrinks into tongues.
// Source: PH 2.4 (fire ball): D(x (1 + turbulence(x))), the solar corona of Perlin 1985 in three dimensions; the offset
// that varies with time is GG 39.5.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move 2 * noise_bound * turbulence_amplitude * hold_radius
// @grow 0
// @drift turbulence_speed * turbulence_frequency
// @param turbulence_amplitude = 1 in [0, 2]: How strongly the turbulence shrinks the object.
// @param turbulence_frequency = 1 in [0.1, 20]: Frequency of the first octave: turbulence cells per object unit.
// @param turbulence_speed = 0.3 in [0, 8]: Speed at which the turbulence rises, object units per second.
#include <turbulence>
#include <phases>
#include <amount>
#include "scale_radius.glsl"
void turbulent(inout vec3 x, inout mat3 jacobian) {
    vec3 p = turbulence_frequency * (x - vec3(0.0, turbulence_speed * time, 0.0));
    // Space beyond this radius is empty, however far the other warps move matter back: the density is 0 from there on.
    float arm = min(length(x), hold_radius);
    float enough = 1.0001 * (own_radius - length(x)) / max(turbulence_amplitude * arm, 1e-6);
    if (sample_reach > 0.0) enough = ALL;      // a segment asks how far outside its ends are
    amounted(enough = ALL;)                    // and of a part of the sum there is more left
    float width = turbulence_frequency * sample_width();
    vec4 sum = moved_by(turbulence_gradient(p, width, UNTIL(enough)), turbulence(p, width, UNTIL(enough)));
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -turbulence_frequency * turbulence_speed, 0.0);
        vec3 q = earlier(p, velocity);
        vec4 before = moved_by(turbulence_gradient(q, width, ALL), turbulence(q, width, ALL));
        sum = passing(sum, before, velocity, SUM_RANGE);
    )
    vec4 t = turbulence_amplitude * sum;
    scale_radius(x, jacobian, t.w, turbulence_frequency * t.xyz);
}
