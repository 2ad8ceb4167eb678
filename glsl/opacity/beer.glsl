// Opacity of a path through a medium whose extinction is a rate times its density.
// Source: Beer-Lambert law: 1 - exp(-density * amount); of a segment by its mean density, exactly.
// density in [0, 1]; amount >= 0: the rate c times the path; result in [0, 1], relative error below 1e-6.
#include "exponential.glsl"

float opacity(float density, float amount) {
    precise float depth = -amount * density;
    return depth < 0.0 ? -exp_minus_one(depth) : 0.0;
}

// The density is linear from d0 at one end to d1 at the other.
float segment_opacity(float d0, float d1, float amount) { return opacity(0.5 * (d0 + d1), amount); }
