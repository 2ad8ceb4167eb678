// Turbulence scales the distance from the center: the object shrinks into tongues.
// Source: PH 2.4 (fire ball): D(x (1 + turbulence(x))), the solar corona of Perlin 1985 in three dimensions; the offset
// that varies with time is GG 39.5.
// x: object space; jacobian: derivative of the displaced by the original point.
// @reach turbulence_amplitude + turbulence_amplitude
// @knob turbulence_amplitude = 1 in [0, 2]: How strongly the turbulence shrinks the object.
// @knob turbulence_frequency = 1 in [0.1, 20]: Frequency of the first octave: turbulence cells per object unit.
// @knob turbulence_speed = 0.3 in [0, 8]: Speed at which the turbulence rises, object units per second.
#include <turbulence>
#include "scale_radius.glsl"
void turbulent(inout vec3 x, inout mat3 jacobian) {
    vec3 p = turbulence_frequency * (x - vec3(0.0, turbulence_speed * time, 0.0));
    vec4 t = turbulence_amplitude * turbulence_gradient(p);
    scale_radius(x, jacobian, t.w, turbulence_frequency * t.xyz);
}
