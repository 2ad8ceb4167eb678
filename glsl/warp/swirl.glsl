// Swirl: the object is looked up at a place that vector-valued noise has moved: hand-blown, wavy matter.
// Source: PH 2.4 (noisy sphere) and 3.1 (vector-valued noise: three noises, far apart).
// x: object space; jacobian: derivative of the displaced by the original point. Moves by at most swirl_depth.
// @reach swirl_depth
// @knob swirl_depth = 0.3 in [0, 1]: Farthest that a point of the surface moves, object units.
// @knob swirl_frequency = 1.6 in [0.1, 20]: Waves of the surface: noise cells per object unit.
#include <noise>
void swirl(inout vec3 x, inout mat3 jacobian) {
    const float EACH = 0.57735;                                     // of three noises in [-1, 1], the length is at most 1
    vec3 p = swirl_frequency * x + 2.17;
    vec4 a = noise_gradient(p + vec3(0.0, 0.0, 5.3));
    vec4 b = noise_gradient(p + vec3(5.3, 0.0, 0.0));
    vec4 c = noise_gradient(p + vec3(0.0, 5.3, 0.0));
    x += swirl_depth * EACH * vec3(a.w, b.w, c.w);
    jacobian = (mat3(1.0) + swirl_depth * EACH * swirl_frequency * transpose(mat3(a.xyz, b.xyz, c.xyz))) * jacobian;
}
