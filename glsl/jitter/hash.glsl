// Each pixel has its own phase of the steps along its ray: contours of the steps become noise, of which the mean over
// many seeds has none.
// Source: PH 3.1 (stochastic ray marching, jittered step phase).
// Result: phase in [-1/2, 1/2) steps, uniform. The mean optical depth over all phases is its integral; of the opacity,
// which is not linear in it, half the variance of the depth remains.
#include "hash.glsl"
#include "pixel.glsl"
float sample_phase() {
    uvec3 bits = hash(uvec3(uvec2(pixel_center), uint(jitter_seed)));
    return float(bits.x >> 8u) / 16777216.0 - 0.5;
}
#include "shift_sample.glsl"
