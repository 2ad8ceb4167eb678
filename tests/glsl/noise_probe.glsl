// Noise and turbulence over a plane.
// Source: MJ 2.3, 4.1.
// Result: 0.5 + 0.5 noise, half the turbulence, 0.
#include <noise>
#include <turbulence>
vec3 surface(Sample s) {
    vec3 p = vec3(3.0 * s.x.xy, 0.37);
    return vec3(0.5 + 0.5 * noise(p), 0.5 * turbulence(p), 0.0);
}
