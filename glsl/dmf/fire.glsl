// Fire: the soft region is torn by turbulence that rises with time and grows with height.
// Source: PH 2.4 (fire ball: D(x (1 + turbulence(x)))), MJ 6 (fire varying with height); the form is a reconstruction.
// density: D in [0, 1]; result in [0, 1].
// @outer flame_length
// @knob flame_length = 0.35 in [0.01, 1.5]: Width of the flames, object units.
// @knob flame_scale = 2.2 in [0.2, 20]: Size of the flames: turbulence cells per object unit.
// @knob fury = 1.25 in [0, 4]: How deep the turbulence cuts into the flames.
// @knob rise = 0.6 in [0, 8]: Speed of the flames, object units per second.
#include <turbulence>
float fire(float density, Sample s) {
    if (density >= 1.0) return 1.0;
    float height = clamp((s.x.y - box_min.y) / (box_max.y - box_min.y), 0.0, 1.0);
    vec3 p = flame_scale * (s.x * vec3(1.0, 0.7, 1.0) - vec3(0.0, rise * time, 0.0));
    float torn = fury * (0.55 + 0.9 * height) * turbulence(p);
    return clamp(density * 1.6 - torn * (1.0 - density * density), 0.0, 1.0);
}
