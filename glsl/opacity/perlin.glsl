// Opacity of a path through constant density, independent of how it is cut into steps; and of a segment.
// Source: PH 3.1: 1 - (1 - density)^(c * step), in the form -expm1(c * step * log1p(-density)).
// density in [0, 1]; amount >= 0: the rate c times the path; result in [0, 1], relative error below 1e-6.
#include "exponential.glsl"

float opacity(float density, float amount) {
    if (density <= 0.0 || amount <= 0.0) return 0.0;
    if (density >= 1.0) return 1.0;
    precise float depth = amount * log_one_minus(density);
    return -exp_minus_one(depth);
}

// The integral of ln u, u = 1 - density, over a segment of length 1 on which u is linear: from G(u) = u ln u - u, or
// about its middle where the ends are so alike that the difference of G would cancel. That is relative to u: with an
// absolute switch the error is 6 times larger. PH 3.1 has no segments: the form is ours.
float mean_log(float d0, float d1) {
    precise float u0 = 1.0 - d0, u1 = 1.0 - d1;
    precise float middle = 0.5 * (u0 + u1);
    precise float e = (d0 - d1) / middle;
    precise float e2 = e * e;
    if (e2 < 0.0625) return log_one_minus(0.5 * (d0 + d1)) - e2 * (1.0 / 24.0 + e2 * (1.0 / 320.0 + e2 / 2688.0));
    precise float g0 = u0 > 0.0 ? u0 * log(u0) : 0.0;
    precise float g1 = u1 > 0.0 ? u1 * log(u1) : 0.0;
    return (g1 - g0) / (d0 - d1) - 1.0;
}

// The density is linear from d0 at one end to d1 at the other; it may reach 1 at one of them.
float segment_opacity(float d0, float d1, float amount) {
    if (d0 + d1 <= 0.0 || amount <= 0.0) return 0.0;
    if (d0 + d1 >= 2.0) return 1.0;
    precise float depth = amount * mean_log(d0, d1);
    return -exp_minus_one(depth);
}
