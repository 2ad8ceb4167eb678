// Swirl: the object is looked up at a place that vector-valued noise has moved: hand-blown, wavy matter.
// Source: PH 2.4 (noisy sphere; tribble: vector-valued noise of three noises, far apart).
// x: object space; jacobian: derivative of the displaced by the original point. Moves by at most swirl_depth.
// @move 1.1547006 * noise_bound * swirl_depth
// @param swirl_depth = 0.3 in [0, 1]: Farthest that a point of the surface moves, object units.
// @param swirl_frequency = 1.6 in [0.1, 20]: Waves of the surface: noise cells per object unit.
#include "vector_noise.glsl"
void swirl(inout vec3 x, inout mat3 jacobian) {
    float each = swirl_depth / 1.5;                                 // vector noise is at most so long
    mat3 slope;
    x += each * vector_noise_slope(swirl_frequency * x, slope);
    jacobian = (mat3(1.0) + each * swirl_frequency * slope) * jacobian;
}
