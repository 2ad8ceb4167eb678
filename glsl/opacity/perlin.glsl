// Opacity of a path through constant density, independent of how it is cut into steps.
// Source: PH 3.1: 1 - (1 - density)^(c * step), in the form -expm1(c * step * log1p(-density)).
// density in [0, 1]; amount >= 0: the rate c times the path; result in [0, 1], relative error below 1e-6.
#include "exponential.glsl"

float opacity(float density, float amount) {
    if (density <= 0.0 || amount <= 0.0) return 0.0;
    if (density >= 1.0) return 1.0;
    precise float depth = amount * log_one_minus(density);
    return -exp_minus_one(depth);
}
