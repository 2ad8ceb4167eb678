// The color of a solid block at a point: veins bent by turbulence, colored by the transfer map.
// Source: MJ 5.1 (a lookup into a block of turbulence); the veins are Perlin's marble.
// x: object space; result: linear RGB.
// @param grain = 2.2 in [0.1, 16]: Size of the pattern: turbulence cells per object unit.
// @param veins = 3.0 in [0, 40]: Veins per object unit; 0 shows the turbulence alone.
// @param distortion = 1.5 in [0, 10]: How far the turbulence bends the veins.
#include <turbulence>
#include <transfer>
vec3 solid_texture(vec3 x) {
    float t = turbulence(grain * x, grain * sample_width());
    float along = dot(x, vec3(0.8, 0.5, 0.33));
    float veined = 0.5 + 0.5 * sin(veins * 3.14159265 * (along + distortion * 0.3 * t));
    float value = mix(0.6 * t, veined, veins > 0.0);
    return transfer(clamp(value, 0.0, 1.0)).rgb;
}
