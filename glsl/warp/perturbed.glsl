// Three scales of vector noise move the place that is looked up: detail on coarse data, and flow when time passes.
// Source: GG 39.5, second method (Kniss et al. 2003): p' = p + sum of w_j N(s_j p + o_j(t)); PH 2.4 (vector-valued noise);
// PH 3.1 (scales finer than a sample fade).
// x: object space; jacobian: derivative of the displaced by the original point.
// @move 1.1547006 * noise_bound * perturbation
// @drift perturbation_speed
// @param perturbation = 0.3 in [0, 2]: No point moves further than this, object units.
// @param perturbation_frequency = 2 in [0.1, 40]: Frequency of the coarsest scale; the others are 2 and 4 times as fine.
// @param perturbation_roughness = 0.5 in [0, 1]: Strength of each scale, in that of the next coarser one.
// @param perturbation_speed = 0.3 in [0, 8]: How fast the noise drifts, cells of the coarsest scale per second.
#include "vector_noise.glsl"
#include <bandlimit>
#include <phases>
void perturbed(inout vec3 x, inout mat3 jacobian) {
    mat3 step = mat3(1.0);
    vec3 moved = x;
    float weight = perturbation * (1.0 / (1.5 * (1.0 + perturbation_roughness + perturbation_roughness * perturbation_roughness)));
    float scale = perturbation_frequency;
    vec3 drift = vec3(0.3125, -1.0, 0.1875) * (perturbation_speed * time);
    SECOND_PHASE(vec3 velocity = vec3(0.3125, -1.0, 0.1875) * perturbation_speed;)
    for (int j = 0; j < 3; ++j) {
        float kept = weight * octave_weight(scale * sample_width());    // a scale that is finer than a sample fades
        mat3 slope;
        vec3 n = vector_noise_slope(scale * x + drift, slope);
        SECOND_PHASE(
            mat3 slope_before;
            n = passing(n, vector_noise_slope(earlier(scale * x + drift, velocity), slope_before), velocity);
            n *= 1.5 / max(length(n), 1.5);                     // as long as vector noise gets
            slope = passing(slope, slope_before, velocity);
            velocity = 1.5 * velocity.zxy;
        )
        moved += kept * n;
        step += kept * scale * slope;
        weight *= perturbation_roughness;
        scale *= 2.0;
        drift = 1.5 * drift.zxy + vec3(3.1, 7.7, 1.3);          // the scales drift in different directions
    }
    x = moved;
    jacobian = step * jacobian;
}
