// Noise and turbulence over a plane, and their derivatives along x.
// Source: MJ 4.1.
// Result: 0.5 + 0.5 noise, half the turbulence, 0.5 + 0.1 of the derivative along x that a parameter chooses.
// @param along = 0 in [0, 2]: 0 none, 1 that of the noise, 2 that of the turbulence.
// @param shift = 0 in [-1000000000, 1000000000]: Cells by which the plane is moved along x.
#include <noise>
#include <turbulence>
vec3 surface(Sample s) {
    vec3 p = vec3(3.0 * s.x.xy, 0.37) + vec3(shift, 0.0, 0.0);
    float slope = along > 1.5 ? turbulence_gradient(p).x : along > 0.5 ? noise_gradient(p).x : 0.0;
    return vec3(0.5 + 0.5 * noise(p), 0.5 * turbulence(p), 0.5 + 0.1 * slope);
}
