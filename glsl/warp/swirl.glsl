// Swirl: the object is looked up at a place that vector-valued noise has moved: hand-blown, wavy matter.
// Source: PH 2.4 (noisy sphere) and 3.1 (vector-valued noise: three noises, far apart).
// x: object space; jacobian: derivative of the displaced by the original point. Moves by at most swirl_depth.
// @reach swirl_depth
// @knob swirl_depth = 0.3 in [0, 1]: Farthest that a point of the surface moves, object units.
// @knob swirl_frequency = 1.6 in [0.1, 20]: Waves of the surface: noise cells per object unit.
#include <noise>
void swirl(inout vec3 x, inout mat3 jacobian) {
    const float EACH = 0.57735;                                     // of three noises in [-1, 1], the length is at most 1
    mat3 rows;
    vec3 moved;
    for (int axis = 0; axis < 3; ++axis) {
        vec4 n = noise_gradient(swirl_frequency * x + 5.3 * vec3(axis == 1, axis == 2, axis == 0) + 2.17);
        rows[axis] = n.xyz;
        moved[axis] = n.w;
    }
    x += swirl_depth * EACH * moved;
    jacobian = (mat3(1.0) + swirl_depth * EACH * swirl_frequency * transpose(rows)) * jacobian;
}
