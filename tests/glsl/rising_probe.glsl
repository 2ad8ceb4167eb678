// Fire, or the relief of its gas, at a place that rises with the flames, 5 units above s.
// Source: MJ 6 (fire). Above the object the flames no longer depend on the height.
// Result: MODE 0: the density of the fire three times; 1: the color of the gas.
#include "dmf/fire.glsl"
#include "medium/flame.glsl"
vec3 surface(Sample s) {
    s.x += vec3(0.0, 5.0 + 0.7 * time, 0.0);
    s.distance = 0.5;
    s.wide_normal = vec3(0.0, 1.0, 0.0);
    s.density = 0.6;
    return MODE == 0 ? vec3(fire(0.6, s)) : medium(s, 0.5);
}
